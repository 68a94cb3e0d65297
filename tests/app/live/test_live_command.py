"""`vesselsplat live` on a folder as if live; its mistakes in one line."""

from __future__ import annotations

import json
import signal
from pathlib import Path

import pytest

from app.__main__ import main
from app.live.picture import LiveStatus
from assets import phantom_path
from renderer.sources import open_clip
from tests.app.apart import called
from tests.app.conftest import Cli


def test_a_clip_as_if_live_is_enhanced_recorded_and_measured(vesselsplat: Cli, tmp_path: Path) -> None:
    film = tmp_path / "new" / "film.mp4"
    done = vesselsplat("live", phantom_path(), "--once", "--record", film, "--what", "side by side", "--json")
    assert done.code == 0
    told = json.loads(done.out)
    assert told["source"] == "phantom"
    assert told["arrived"] + told["dropped"] >= told["made"] > 10
    assert told["ends"] == "ended"
    delay = told["milliseconds_from_arrival_to_enhanced"]
    assert 0 < delay["median"] <= delay["p95"] <= delay["worst"]
    width, height = open_clip(phantom_path()).size
    assert open_clip(film).size == (2 * width, height)
    assert len(open_clip(film)) == told["recording"]["pictures"]
    assert vesselsplat("info", film).code == 0
    refused = vesselsplat("replay", film)
    assert (refused.code, "of its moment" in refused.error) == (2, True)


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        ((), "expected a SOURCE"),
        (("nosuch",), "expected a capture device"),
        (("gopher://x",), "expected a stream by"),
        (("77",), "got no such device: /dev/video77"),
        ((str(phantom_path()), "--right", "/dev/video78"), "got no such device: /dev/video78"),
        (("tcp://127.0.0.1:9", "--seconds", "0.6"), "no frame came from tcp://127.0.0.1:9"),
        ((str(phantom_path()), "--seconds", "0"), "--seconds"),
        ((str(phantom_path()), "--fps", "-1"), "--fps"),
        ((str(phantom_path()), "--record", "film.avi"), "expected a recording to end in .mp4"),
        ((str(phantom_path()), "--what", "original"), "--what: expected --record FILE.mp4 with it"),
        (
            (str(phantom_path()), "--size", "64", "48"),
            "--size: expected a device as SOURCE, to which it applies",
        ),
        ((str(phantom_path()), "--pixel-format", "MJPG"), "--pixel-format: expected a device as SOURCE"),
        (("tcp://127.0.0.1:9", "--pixel-format", "MJPEG"), "--pixel-format: expected four characters"),
        (("tcp://127.0.0.1:9", "--pixel-format", "x"), "such as MJPG, got x"),
        (("tcp://127.0.0.1:9", "--fps", "25"), "--fps: expected a device or file as SOURCE"),
        (("tcp://127.0.0.1:9", "--once"), "--once: expected a file as SOURCE"),
        ((str(phantom_path()), "--coring", "1"), "--coring has no effect"),
        (("--list", "--record", "a.mp4"), "--record has no effect with --list"),
    ],
)
def test_mistakes_are_one_line(vesselsplat: Cli, flags: tuple[str, ...], said: str) -> None:
    done = vesselsplat("live", *flags)
    assert done.code == 2
    assert said in done.error
    assert "Traceback" not in done.error


def test_a_source_that_never_came_is_told_once_and_not_as_lost(
    vesselsplat: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.commands.live.PATIENCE", 2.5)
    done = vesselsplat("live", "tcp://127.0.0.1:9")
    refused = "nothing can be received from tcp://127.0.0.1:9 (connection refused)"
    assert done.code == 2
    assert done.error.splitlines() == [f"live: waiting for the source: {refused}", f"vesselsplat: {refused}"]


def ended_at_the_third_frame(arguments: list[str]) -> int:
    """By Ctrl+C."""

    def line_of(now: LiveStatus) -> str:
        if now.made >= 3:
            signal.raise_signal(signal.SIGINT)
        return ""

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("app.commands.live.line_of", line_of)
        return main(arguments)


def test_ctrl_c_ends_it_as_the_time_does(tmp_path: Path) -> None:
    film = tmp_path / "film.mp4"
    arguments = ["live", str(phantom_path()), "--record", str(film), "--seconds", "20", "--json"]
    done = called(ended_at_the_third_frame, arguments, folder=tmp_path, seconds=50)
    assert (done.code, "Traceback" in done.error, "interrupted" in done.error) == (0, False, False)
    told = json.loads(done.out)
    assert told["made"] >= 3
    assert told["seconds"] < 20
    assert len(open_clip(film)) == told["recording"]["pictures"] > 0


def test_ctrl_c_before_the_first_frame_is_no_fault_of_the_source(
    vesselsplat: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.commands.live._follow", lambda *_: signal.raise_signal(signal.SIGINT))
    monkeypatch.setattr("app.commands.live.load", lambda _: None)
    done = vesselsplat("live", "tcp://127.0.0.1:9")
    assert (done.code, done.error) == (130, "vesselsplat: interrupted\n")


def test_a_recording_that_ends_early_is_told_at_once(vesselsplat: Cli, tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"no folder")
    done = vesselsplat("live", phantom_path(), "--seconds", "1.5", "--record", tmp_path / "file" / "x.mp4")
    assert done.code == 2
    told = [line for line in done.error.splitlines() if "ended early" in line]
    assert [line.split(":")[0] for line in told] == ["live", "vesselsplat"]


def test_devices_are_listed(vesselsplat: Cli) -> None:
    done = vesselsplat("live", "--list", "--json")
    assert done.code == 0
    assert isinstance(json.loads(done.out)["devices"], list)
