"""`vesselsplat enhance`: types kept, provenance embedded, statistics as asked."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.pictures import read_image
from app.provenance import digest, read_provenance
from enhance import EnhanceParams, enhance, measure
from renderer.sources import open_clip
from tests.app.conftest import Call

Cli = Callable[..., Call]


def tissue(seed: int, brightness: int = 160) -> np.ndarray:
    """(40, 60, 3) BGR uint8, reddish and smooth."""
    noise = np.random.default_rng(seed).normal(0, 20, (40, 60, 3))
    smooth = cv2.GaussianBlur(noise, (9, 9), 2) * 4
    return np.clip(np.array([60, 70, brightness]) + smooth, 0, 255).astype(np.uint8)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    path = tmp_path / "in"
    path.mkdir()
    for index, brightness in enumerate((90, 160, 230)):
        cv2.imwrite(str(path / f"{index}.png"), tissue(index, brightness))
    return path


def test_a_picture_is_what_the_library_makes_of_it(folder: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    given, out = folder / "1.png", tmp_path / "new" / "out.png"
    call = vesselsplat("enhance", given, out, "--z", "0.3", "--p", "0.4", "--radii", "2", "5", "--json")
    assert call.code == 0
    params = EnhanceParams(z=0.3, p=0.4, radii=(2, 5))
    assert np.array_equal(read_image(out), enhance(read_image(given), params).image)
    facts = read_provenance(out)
    assert facts["source"] == {"name": "1.png", "sha256": digest(given)}
    assert (facts["params"]["z"], facts["params"]["radii"]) == (0.3, [2, 5])
    assert str(tmp_path) not in json.dumps(facts)
    summary = json.loads(call.out)
    assert summary["pictures"][0]["statistics"] == facts["statistics"]


def test_sixteen_bits_and_alpha_are_kept(tmp_path: Path, vesselsplat: Cli) -> None:
    colors = tissue(1).astype(np.uint16) * 257
    alpha = np.random.default_rng(0).integers(1, 65535, colors.shape[:2], dtype=np.uint16)
    cv2.imwrite(str(tmp_path / "in.png"), np.dstack((colors, alpha)))
    assert vesselsplat("enhance", tmp_path / "in.png", tmp_path / "out.png").code == 0
    out = cv2.imread(str(tmp_path / "out.png"), cv2.IMREAD_UNCHANGED)
    assert (out.dtype, out.shape) == (np.uint16, (40, 60, 4))
    assert np.array_equal(out[..., 3], alpha)
    assert not np.array_equal(out[..., :3], colors)


@pytest.mark.parametrize("statistics", ["image", "clip"])
def test_statistics_are_of_each_picture_or_of_all(
    folder: Path, tmp_path: Path, vesselsplat: Cli, statistics: str
) -> None:
    call = vesselsplat("enhance", folder, tmp_path / "out", "--statistics", statistics, "--json")
    images = [read_image(folder / f"{index}.png") for index in range(3)]
    pooled = measure(images, EnhanceParams()) if statistics == "clip" else None
    pictures = json.loads(call.out)["pictures"]
    assert [picture["output"] for picture in pictures] == ["0.png", "1.png", "2.png"]
    for image, picture in zip(images, pictures, strict=True):
        expected = enhance(image, EnhanceParams(), statistics=pooled)
        assert np.array_equal(read_image(tmp_path / "out" / picture["output"]), expected.image)
        assert picture["statistics"]["scope"] == statistics
    levels = {picture["statistics"]["level"] for picture in pictures}
    assert len(levels) == (1 if statistics == "clip" else 3)


def test_a_video_keeps_its_frames_and_its_speed(tmp_path: Path, vesselsplat: Cli) -> None:
    given, out = tmp_path / "in.mp4", tmp_path / "out.mp4"
    writer = cv2.VideoWriter(str(given), cv2.VideoWriter.fourcc(*"mp4v"), 10.0, (64, 48))
    for index in range(5):
        writer.write(cv2.resize(tissue(index), (64, 48)))
    writer.release()
    call = vesselsplat("enhance", given, out, "--statistics", "clip")
    assert (call.code, call.error) == (0, "")
    clip = open_clip(out)
    assert (len(clip), clip.size, clip.frames_per_second) == (5, (64, 48), 10.0)
    beside = json.loads((tmp_path / "out.mp4.json").read_text())
    assert [picture["picture"] for picture in beside["pictures"]] == [f"frame-{i:06d}" for i in range(5)]
    frames = tmp_path / "frames"
    assert vesselsplat("enhance", given, frames).code == 0
    assert len(list(frames.iterdir())) == 5


def test_a_clip_folder_is_its_images(clip_path: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    call = vesselsplat("enhance", clip_path, tmp_path / "out", "--json")
    images = sorted(path.stem for path in (clip_path / "images").iterdir())
    assert [picture["picture"] for picture in json.loads(call.out)["pictures"]] == images


def test_two_pictures_of_one_output_name_are_refused(folder: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    cv2.imwrite(str(folder / "0.jpg"), tissue(9))
    call = vesselsplat("enhance", folder, tmp_path / "out")
    assert call.code == 2
    assert "0.jpg and 0.png" in call.error or "0.png and 0.jpg" in call.error
    assert not (tmp_path / "out").exists()


def test_metrics_against_itself_is_perfect(folder: Path, vesselsplat: Cli) -> None:
    path = folder / "1.png"
    report = json.loads(vesselsplat("metrics", path, "--against", path, "--json").out)
    assert report["mean"]["ssim"] == pytest.approx(1.0)
    assert report["mean"]["psnr"] is None  # infinite: strict JSON has no word for it
    assert report["images"][0]["dv"] == report["images"][0]["original"]["dv"]
