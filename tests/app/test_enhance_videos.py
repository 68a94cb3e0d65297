"""`vesselsplat enhance` of videos: speed, statistics, and what is left of a damaged one."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from app.__main__ import main
from app.enhancement.enhance_files import Setting, enhance_into
from app.files.image_files import ArrayImage
from app.files.image_series import Series
from app.files.stepping import run_to_end
from app.files.timing import Timing
from enhance import EnhanceParams
from renderer.clip import ClipError
from renderer.sources import open_clip
from tests.app.conftest import Cli, tissue
from tests.app.files.test_video import without


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


@pytest.mark.parametrize(("flags", "steady"), [((), True), (("--statistics", "image"), False)])
def test_a_video_has_one_statistics_unless_told_otherwise(
    tmp_path: Path, vesselsplat: Cli, flags: tuple[str, ...], steady: bool
) -> None:
    given = tmp_path / "in.mp4"
    writer = cv2.VideoWriter(str(given), cv2.VideoWriter.fourcc(*"mp4v"), 10.0, (64, 48))
    for index in range(5):
        writer.write(cv2.resize(tissue(index, 120 + 20 * index), (64, 48)))
    writer.release()
    call = vesselsplat("enhance", given, tmp_path / "out.mp4", *flags, "--json")
    used = [picture["statistics"] for picture in json.loads(call.out)["pictures"]]
    assert (len({one["level"] for one in used}) == 1) == steady
    assert {one["scope"] for one in used} == {"clip" if steady else "image"}


def test_a_video_of_several_sizes_is_refused_before_it_is_begun(
    folder: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    cv2.imwrite(str(folder / "9.png"), np.zeros((30, 60, 3), np.uint8))
    call = vesselsplat("enhance", folder, tmp_path / "out.mp4")
    assert call.code == 2
    assert "60x40" in call.error
    assert "1 of 4 images (9.png)" in call.error


def test_a_folder_of_videos_says_what_to_do(tmp_path: Path, vesselsplat: Cli) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a.mp4").write_bytes(b"x")
    call = vesselsplat("enhance", tmp_path / "in", tmp_path / "out")
    assert call.code == 2
    assert "a.mp4" in call.error
    assert "--recursive" in call.error


@pytest.mark.parametrize("statistics", ["image", "clip"])
def test_a_video_that_breaks_off_leaves_what_was_whole(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, statistics: str
) -> None:
    given, out = tmp_path / "in.mp4", tmp_path / "out.mp4"
    given.write_bytes(b"video")

    def read(index: int) -> np.ndarray:
        if index == 3:
            raise ClipError(f"frame 3 of 8 cannot be decoded: {given}")
        return tissue(index)

    names = tuple(str(index) for index in range(8))
    series = Series(names, (given,) * 8, read, is_video=True, timing=Timing(12.0, like=given))
    monkeypatch.setattr("app.commands.enhance.open_series", lambda path, options: series)
    without(monkeypatch, "PyAV", "ffmpeg")
    assert main(["enhance", str(given), str(out), "--statistics", statistics]) == 0
    captured = capfd.readouterr()
    stopped, sound = captured.err.splitlines()
    assert stopped == f"stopped after 3 of 8 frames: frame 3 of 8 cannot be decoded: {given}"
    assert sound.startswith("sound is not kept")
    assert "3 enhanced" in captured.out
    clip = open_clip(out)
    assert (len(clip), clip.size, clip.frames_per_second) == (3, (60, 40), 12.0)
    assert "stopped after 3" in json.loads((tmp_path / "out.mp4.json").read_text())["notices"][0]


def test_a_truncated_video_becomes_a_shorter_one(tmp_path: Path, vesselsplat: Cli) -> None:
    given, out = tmp_path / "in.avi", tmp_path / "out.mp4"
    writer = cv2.VideoWriter(str(given), cv2.VideoWriter.fourcc(*"MJPG"), 10.0, (64, 48))
    for index in range(40):
        writer.write(cv2.resize(tissue(index), (64, 48)))
    writer.release()
    given.write_bytes(given.read_bytes()[: given.stat().st_size // 2])
    call = vesselsplat("enhance", given, out)
    assert call.code == 0
    assert call.error.count("\n") == 1
    assert "cut off" in call.error
    assert 2 <= len(open_clip(out)) < 40


def test_a_video_that_stops_is_told_once(tmp_path: Path) -> None:
    """Where its enhanced frames end, and not where those of its statistics do."""

    def read(index: int) -> ArrayImage:
        if index >= 20:
            raise ClipError(f"another size in frame {index}")
        return tissue(index)

    names = tuple(f"frame-{index:06d}" for index in range(40))
    (tmp_path / "in.ts").write_bytes(b"of the stream")
    series = Series(names, (tmp_path / "in.ts",) * 40, read, is_video=True)
    setting = Setting("paper", EnhanceParams(d_factor=0.5))
    written = run_to_end(enhance_into(tmp_path / "out", series, setting))
    assert written.notices == ("stopped after 20 of 40 frames: another size in frame 20",)


def test_a_video_holds_one_size_of_images_without_suffix_too(tmp_path: Path, vesselsplat: Cli) -> None:
    given = tmp_path / "given"
    given.mkdir()
    for name, width in (("a.png", 64), ("b", 48)):
        Image.new("RGB", (width, 48), "red").save(given / name, "PNG")
    call = vesselsplat("enhance", given, tmp_path / "out.mp4")
    assert (call.code, (tmp_path / "out.mp4").exists()) == (2, False)
    assert "expected one size, 64x48 as a.png, got 48x48" in call.error
