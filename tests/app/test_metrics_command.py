"""`vesselsplat metrics`: what it measures of pictures, of pairs and of sequences."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.files.provenance import digest
from renderer.sources import open_clip
from tests.app.conftest import Cli, tissue
from tests.renderer.readers.test_hamlyn import write_hamlyn


def test_metrics_against_itself_is_perfect(folder: Path, vesselsplat: Cli) -> None:
    path = folder / "1.png"
    report = json.loads(vesselsplat("metrics", path, "--against", path, "--json").out)
    assert report["mean"]["ssim"] == pytest.approx(1.0)
    assert report["mean"]["psnr"] is None  # infinite: strict JSON has no word for it
    assert report["images"][0]["dv"] == report["images"][0]["original"]["dv"]


def test_one_undefined_measure_leaves_the_mean_of_the_others(
    folder: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    blank = tmp_path / "blank.png"
    cv2.imwrite(str(blank), np.full((40, 60, 3), 90, np.uint8))
    report = json.loads(vesselsplat("metrics", folder / "1.png", blank, "--json").out)
    first, second = report["images"]
    assert second["dv_bv"] is None
    assert report["mean"]["dv_bv"] == first["dv_bv"]
    assert "null" in report["definitions"]
    equal = ("metrics", folder / "1.png", folder / "2.png", "--against", folder / "1.png", folder / "1.png")
    report = json.loads(vesselsplat(*equal, "--json").out)
    assert report["images"][0]["psnr"] is None
    assert report["mean"]["psnr"] == report["images"][1]["psnr"]
    assert vesselsplat(*equal).code == 0


def test_names_are_printed_as_they_are(folder: Path, vesselsplat: Cli) -> None:
    name = "img[a] [red]:smile:.png"
    (folder / "1.png").rename(folder / name)
    assert name in vesselsplat("metrics", folder / name).out


def test_metrics_know_contrast_noise_and_black_vessels(tmp_path: Path, vesselsplat: Cli) -> None:
    rng = np.random.default_rng(4)
    image = np.clip(rng.normal((60, 100, 170), 2, (90, 120, 3)), 0, 255)
    image[:, 58:62] *= (0.5, 0.5, 0.9)
    before = np.rint(image).astype(np.uint8)
    after = before.copy()
    after[:, 58:62] //= 4
    truth = np.zeros((90, 120), np.uint8)
    truth[:, 58:62] = 255
    for name, picture in (("before", before), ("after", after), ("truth", truth)):
        cv2.imwrite(str(tmp_path / f"{name}.png"), picture)
    paths = [tmp_path / f"{name}.png" for name in ("after", "before", "truth")]
    alone = json.loads(vesselsplat("metrics", paths[1], "--vessels", paths[2], "--json").out)
    assert alone["mean"]["vessel_contrast"] == pytest.approx(0.5, abs=0.02)
    cv2.imwrite(str(tmp_path / "truth.jpg"), truth, (cv2.IMWRITE_JPEG_QUALITY, 60))
    lossy = json.loads(vesselsplat("metrics", paths[1], "--vessels", tmp_path / "truth.jpg", "--json").out)
    assert lossy["mean"]["vessel_contrast"] == pytest.approx(0.5, abs=0.05)
    report = json.loads(vesselsplat("metrics", paths[0], "--against", paths[1], "--json").out)
    mean, original = report["mean"], report["images"][0]["original"]
    assert original["vessel_contrast"] == pytest.approx(0.5, abs=0.05)
    assert mean["vessel_contrast"] == pytest.approx(0.875, abs=0.05)
    assert mean["vessel_cnr"] > original["vessel_cnr"]
    assert mean["noise_gain"] == pytest.approx(1.0, abs=0.02)
    assert mean["blackened_share"] > 0.95
    assert set(report["definitions"]) >= {"vessel_contrast", "noise_gain", "blackened_share"}
    both = json.loads(
        vesselsplat("metrics", paths[0], "--against", paths[1], "--vessels", paths[2], "--json").out
    )
    assert both["images"][0]["original"]["vessel_contrast"] == alone["mean"]["vessel_contrast"]


def test_metrics_want_one_mask_a_picture_and_of_its_size(
    folder: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    small = tmp_path / "small.png"
    cv2.imwrite(str(small), np.zeros((8, 8), np.uint8))
    pictures = (folder / "0.png", folder / "1.png")
    call = vesselsplat("metrics", *pictures, "--vessels", small)
    assert (call.code, "one vessel mask for each of 2" in call.error) == (2, True)
    call = vesselsplat("metrics", pictures[0], "--vessels", small)
    assert (call.code, "60x40, got 8x8" in call.error, call.error.count("\n")) == (2, True, 1)
    np.save(tmp_path / "line.npy", np.ones(40, np.uint8))
    call = vesselsplat("metrics", pictures[0], "--vessels", tmp_path / "line.npy")
    assert (call.code, "mask of shape (H, W), got (40,)" in call.error, call.error.count("\n")) == (
        2,
        True,
        1,
    )


def test_the_error_is_that_of_what_is_not_transparent(tmp_path: Path, vesselsplat: Cli) -> None:
    before = np.random.default_rng(0).integers(60, 200, (40, 64, 3)).astype(np.uint8)
    alpha = np.full((40, 64), 255, np.uint8)
    alpha[:, 16:] = 0
    after = np.dstack((before + 10, alpha))
    found = []
    for name, columns in (("whole", 64), ("part", 16)):
        paths = [tmp_path / f"{name}-{kind}.png" for kind in ("after", "before")]
        for path, image in zip(paths, (after, before), strict=True):
            cv2.imwrite(str(path), image[:, :columns])
        report = json.loads(vesselsplat("metrics", paths[0], "--against", paths[1], "--json").out)
        found.append([report["mean"][name] for name in ("psnr", "ssim")])
    assert found[0] == pytest.approx(found[1])
    assert found[0][0] == pytest.approx(20 * np.log10(255 / 10))


def test_metrics_of_a_sequence_say_how_steady_it_is(folder: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    scene = tissue(0) // 2
    for index, level in enumerate((10, 20, 0)):
        cv2.imwrite(str(tmp_path / f"{index}.png"), scene + np.uint8(level))
        cv2.imwrite(str(folder / f"{index}.png"), scene + np.uint8(index))
    paths = [tmp_path / f"{index}.png" for index in range(3)]
    alone = json.loads(vesselsplat("metrics", *paths, "--json").out)
    assert alone["sequence"] == {"luma_step": pytest.approx(15)}
    report = json.loads(vesselsplat("metrics", *paths, "--against", folder, "--json").out)
    assert report["sequence"] == {"luma_step": pytest.approx(15), "flicker": pytest.approx(14)}
    assert "flicker: 14" in vesselsplat("metrics", *paths, "--against", folder).out
    assert json.loads(vesselsplat("metrics", paths[0], "--json").out)["sequence"] is None
    apart = json.loads(vesselsplat("metrics", paths[0], folder / "1.png", "--json").out)
    assert apart["sequence"] is None
    cv2.imwrite(str(tmp_path / "other.png"), tissue(7))
    unlike = json.loads(vesselsplat("metrics", paths[0], tmp_path / "other.png", "--json").out)
    assert unlike["sequence"] is None
    assert {"luma_step", "flicker"} <= set(report["definitions"])


def test_metrics_take_the_frames_of_a_video(folder: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    video = tmp_path / "in.avi"
    writer = cv2.VideoWriter(str(video), cv2.VideoWriter.fourcc(*"MJPG"), 10.0, (60, 40))
    for index in range(3):
        writer.write(tissue(index, 100 + 20 * index))
    writer.release()
    report = json.loads(vesselsplat("metrics", video, "--against", video, "--json").out)
    assert [picture["image"]["frame"] for picture in report["images"]] == [0, 1, 2]
    assert {picture["image"]["sha256"] for picture in report["images"]} == {digest(video)}
    assert report["sequence"]["luma_step"] > 1
    assert report["sequence"]["flicker"] == 0
    assert "in.avi 2" in vesselsplat("metrics", video).out
    call = vesselsplat("metrics", video, "--against", folder / "0.png", folder / "1.png")
    assert (call.code, "one original for each of 3" in call.error) == (2, True)


def test_frames_of_a_data_set_have_their_numbers_and_two_clips_are_no_sequence(
    tmp_path: Path, vesselsplat: Cli
) -> None:
    one = write_hamlyn(tmp_path / "a")
    told = json.loads(vesselsplat("metrics", one, "--json").out)
    assert [one["image"]["frame"] for one in told["images"]] == list(range(len(open_clip(one))))
    assert told["sequence"] is not None
    both = json.loads(vesselsplat("metrics", one, write_hamlyn(tmp_path / "b"), "--json").out)
    assert (len(both["images"]), both["sequence"]) == (2 * len(told["images"]), None)


def test_a_frame_of_a_data_set_that_was_tuned_comes_again(tmp_path: Path, vesselsplat: Cli) -> None:
    clip, out = write_hamlyn(tmp_path / "a"), tmp_path / "out"
    tuned = vesselsplat("tune", clip, "--out", out, "--frame", 2, "--vary", "z=0.2,0.6")
    assert tuned.code == 0, tuned.error
    again = vesselsplat("replay", out / "setting-000.png", "--source", clip)
    assert again.out.rstrip().endswith("identical"), again.error + again.out
