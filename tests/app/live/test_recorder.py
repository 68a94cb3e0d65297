"""What is recorded plays: after its end, after a kill, on a full disk; with its times and settings."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import av
import numpy as np
import pytest

from app.errors import UserError
from app.files.provenance import write_sidecar
from app.live.picture import LivePicture, LiveSetting
from app.live.recorder import WHATS, Recorder, Recording, require_new, shown
from app.live.segment import Segment
from app.live.sources.played import PlayedSource
from app.live.sources.source import Wish
from enhance import EnhanceParams
from renderer.sources import open_clip
from tests.app.conftest import ROOT
from tests.app.live.painted import painted, wait_for

SETTING = LiveSetting(EnhanceParams())
LIVE = """
import sys, time
from pathlib import Path
from app.live.recorder import Recorder
from tests.app.live.test_recorder import picture

recorder = Recorder(Path(sys.argv[1]), "original", "a source")
start = time.perf_counter()
for number in range(4000):
    time.sleep(max(start + number / 50 - time.perf_counter(), 0))
    recorder.add(picture(number, time.perf_counter() - start))
    sys.stdout.write(f"{time.perf_counter() - start}\\n")
    sys.stdout.flush()
"""
FULL = """
import resource, signal, sys, time
from pathlib import Path
from app.live.recorder import Recorder
from tests.app.live.test_recorder import picture

signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))
recorder = Recorder(Path(sys.argv[1]), "original", "a source")
for number in range(4000):
    if recorder.state.is_over:
        break
    recorder.add(picture(number, number / 50))
    time.sleep(0.002)
sys.stdout.write(recorder.finish().trouble)
"""


def picture(number: int, seconds: float, size: tuple[int, int] = (96, 128)) -> LivePicture:
    """Noise beside the level: what an encoder cannot make small."""
    level = 40 + 4 * (number % 40)
    original = painted(level, size)
    original[:, : size[1] // 2] = np.random.default_rng(number).integers(0, 255, (size[0], size[1] // 2, 3))
    return LivePicture(number, seconds, original, 255 - original, SETTING, None, (), 1.0)


def recorded(path: Path, pictures: list[LivePicture]) -> Recording:
    recorder = Recorder(path, "original", "a source")
    for one in pictures:
        recorder.add(one)
        wait_for(
            lambda one=one: recorder.state.pictures >= one.number or recorder.state.is_over, "the encoder"
        )
    return recorder.finish()


def test_a_recording_keeps_pictures_and_their_times(tmp_path: Path) -> None:
    seconds = [0.0, 0.04, 0.08, 0.2, 0.24, 1.0, 1.04]
    done = recorded(tmp_path / "a.mp4", [picture(at + 1, when) for at, when in enumerate(seconds)])
    clip = open_clip(done.path)
    assert done == Recording(tmp_path / "a.mp4", "original", 1.04, 7, is_over=True)
    assert clip.frame_times == pytest.approx(seconds, abs=1e-4)
    for at in range(7):
        right = slice(70, None)
        apart = clip.read_image(at)[:, right].astype(float) - picture(at + 1, 0).original[:, right]
        assert np.abs(apart[:40]).mean() < 3
    facts = json.loads((tmp_path / "a.mp4.json").read_text())
    assert facts["kind"] == "live recording"
    assert facts["settings"][0]["params"]["radii"] == [4, 16, 64]
    assert str(tmp_path) not in json.dumps(facts)


def test_a_changed_setting_is_noted_with_its_time(tmp_path: Path) -> None:
    other = LiveSetting(EnhanceParams(z=0.1))
    pictures = [picture(1, 0.0), picture(2, 0.5), replace(picture(3, 1.0), setting=other)]
    recorded(tmp_path / "a.mp4", pictures)
    told = json.loads((tmp_path / "a.mp4.json").read_text())["settings"]
    assert [(one["from_seconds"], one["params"]["z"]) for one in told] == [(0.0, None), (1.0, 0.1)]


def test_settings_that_change_with_every_picture_cost_no_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As while a slider is dragged, on a disk where each writing of the record takes its time."""
    said = list[int]()

    def slow(path: Path, facts: dict[str, Any]) -> None:
        time.sleep(0.5)
        said.append(len(facts["settings"]))
        write_sidecar(path, facts)

    for name in ("recorder", "sidecar"):
        monkeypatch.setattr(f"app.live.{name}.write_sidecar", slow)
    recorder, start = Recorder(tmp_path / "a.mp4", "original", "a source"), time.perf_counter()
    for number in range(60):
        time.sleep(max(start + number / 40 - time.perf_counter(), 0))
        setting = LiveSetting(EnhanceParams(z=number / 100))
        recorder.add(replace(picture(number, number / 40, (32, 32)), setting=setting))
    done = recorder.finish()
    assert (done.pictures, done.left_out, done.trouble) == (60, 0, "")
    told = json.loads((tmp_path / "a.mp4.json").read_text())["settings"]
    assert [one["params"]["z"] for one in told] == [number / 100 for number in range(60)]
    assert said[0] < 30
    assert len(said) <= 3


def test_a_record_that_cannot_be_written_ends_the_recording(tmp_path: Path) -> None:
    (tmp_path / "a.mp4.json").mkdir()
    assert "a.mp4.json" in recorded(tmp_path / "a.mp4", [picture(1, 0.0)]).trouble


def test_another_size_goes_on_in_another_file(tmp_path: Path) -> None:
    pictures = [picture(1, 0.0), picture(2, 0.1), picture(3, 0.2, (64, 64)), picture(4, 0.3, (64, 64))]
    done = recorded(tmp_path / "a.mp4", pictures)
    assert (done.files, done.path.name) == (2, "a-2.mp4")
    assert [open_clip(tmp_path / name).size for name in ("a.mp4", "a-2.mp4")] == [(128, 96), (64, 64)]
    told = json.loads((tmp_path / "a.mp4.json").read_text())["files"]
    assert told == [{"name": "a.mp4", "from_seconds": 0.0}, {"name": "a-2.mp4", "from_seconds": 0.2}]


def test_what_the_encoder_cannot_hold_ends_it_in_a_line(tmp_path: Path) -> None:
    wide = picture(1, 0.0, (16, 17000))
    done = recorded(tmp_path / "a.mp4", [wide])
    assert (done.is_over, done.pictures) == (True, 0)
    assert done.trouble.startswith("H.264 cannot hold frames of 17000x16 (")
    assert not list(tmp_path.iterdir())
    done = recorded(tmp_path / "a.mp4", [picture(1, 0.0), picture(2, 0.1), replace(wide, number=3)])
    assert (done.path.name, done.files, done.pictures) == ("a.mp4", 1, 2)
    assert "cannot hold" in done.trouble
    assert {path.name for path in tmp_path.iterdir()} == {"a.mp4", "a.mp4.json"}
    assert len(open_clip(done.path)) == 2


@pytest.mark.parametrize("fails", ["write", "finish"])
def test_whatever_fails_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fails: str) -> None:
    def failing(*given: object) -> None:
        raise RuntimeError("of the driver")

    monkeypatch.setattr(f"app.live.segment.Segment.{fails}", failing)
    done = recorded(tmp_path / "a.mp4", [picture(1, 0.0)])
    assert (done.is_over, done.trouble) == (True, "of the driver")


def test_what_the_encoder_refuses_at_the_end_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(*given: object) -> None:
        raise av.error.InvalidDataError(1, "no more")

    segment = Segment(tmp_path / "a.mp4", (64, 48), 0.0, {})
    monkeypatch.setattr(segment, "_stream", SimpleNamespace(encode=failing))
    with pytest.raises(UserError, match=r"H.264 cannot hold frames of 64x48 \(no more\)"):
        segment.finish()


def test_pixels_that_are_not_square_stay_so_and_play_so(tmp_path: Path) -> None:
    """As of a standard-definition camera; another shape goes on in another file."""
    wide = [replace(picture(number, number / 25), pixel_aspect=64 / 45) for number in (1, 2)]
    done = recorded(tmp_path / "a.mp4", [*wide, picture(3, 3 / 25)])
    assert done.files == 2
    for name, aspect in (("a.mp4", 64 / 45), ("a-2.mp4", 1.0)):
        assert open_clip(tmp_path / name).pixel_aspect == pytest.approx(aspect)
        arrived = PlayedSource(tmp_path / name, Wish(loop=False)).read()
        assert arrived is not None
        assert arrived.pixel_aspect == pytest.approx(aspect)


def test_without_a_picture_there_is_no_file(tmp_path: Path) -> None:
    assert Recorder(tmp_path / "a.mp4", "enhanced", "a source").finish().is_over
    assert not list(tmp_path.iterdir())


def test_a_disk_that_is_full_from_the_start_leaves_no_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.live.recorder.LEAST_FREE", 2**62)
    done = recorded(tmp_path / "a.mp4", [picture(1, 0.0)])
    assert "the disk is nearly full" in done.trouble
    assert not list(tmp_path.iterdir())
    require_new(tmp_path / "a.mp4")


def test_a_file_that_is_there_is_not_taken_away(tmp_path: Path) -> None:
    (tmp_path / "a.mp4").write_bytes(b"of another")
    assert "exists" in recorded(tmp_path / "a.mp4", [picture(1, 0.0)]).trouble
    assert (tmp_path / "a.mp4").read_bytes() == b"of another"


@pytest.mark.parametrize("what", WHATS)
def test_what_is_recorded_is_what_was_asked_for(what: str) -> None:
    one = picture(1, 0.0, (31, 41))
    assert one.enhanced is not None
    whole = {"original": one.original, "enhanced": one.enhanced}.get(what)
    if whole is None:
        whole = np.concatenate((one.original, one.enhanced), axis=1)
    assert np.array_equal(shown(one, what), whole[:30, : whole.shape[1] // 2 * 2])  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["a.avi", "there.mp4"])
def test_a_wrong_or_taken_name_is_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "there.mp4").write_bytes(b"mine")
    with pytest.raises(UserError, match=name):
        require_new(tmp_path / name)
    assert Recorder(tmp_path / "there.mp4", "original", "x").finish().trouble
    assert (tmp_path / "there.mp4").read_bytes() == b"mine"


def started(code: str, path: Path) -> subprocess.Popen[str]:
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    line = [sys.executable, "-c", code, str(path)]
    return subprocess.Popen(line, stdout=subprocess.PIPE, text=True, env=environment)


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="kills as POSIX does")
def test_a_killed_recording_plays_and_lacks_no_more_than_a_second(tmp_path: Path) -> None:
    last = 0.0
    with started(LIVE, tmp_path / "a.mp4") as process:
        assert process.stdout is not None
        while last < 2.3:
            last = float(process.stdout.readline())
        process.kill()
        last = max([last, *map(float, process.stdout.read().split("\n")[:-1])])
    clip = open_clip(tmp_path / "a.mp4")
    assert clip.frame_times is not None
    assert last - 1.0 < clip.frame_times[-1] <= last
    assert clip.read_image(len(clip) - 1).shape == (96, 128, 3)
    assert json.loads((tmp_path / "a.mp4.json").read_text())["kind"] == "live recording"


@pytest.mark.skipif(sys.platform != "linux", reason="limits files as Linux does")
def test_a_full_disk_ends_the_recording_in_a_line_and_what_is_there_plays(tmp_path: Path) -> None:
    with started(FULL, tmp_path / "a.mp4") as process:
        said, _ = process.communicate(timeout=60)
    assert process.returncode == 0
    assert "too large" in said.lower()
    assert len(open_clip(tmp_path / "a.mp4")) > 10


def test_a_busy_encoder_leaves_pictures_out_and_counts_them(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "a.mp4", "original", "a source")
    start = time.perf_counter()
    for number in range(1, 120):
        recorder.add(picture(number, number / 50))
    assert time.perf_counter() - start < 5
    done = recorder.finish()
    assert done.pictures + done.left_out == 119
