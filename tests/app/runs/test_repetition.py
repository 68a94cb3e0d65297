"""`render` and `export` twice: the same bytes in every file."""

from __future__ import annotations

import time
from datetime import datetime
from pathlib import Path

import pytest

from tests.app.conftest import Cli


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


@pytest.fixture
def passing_hours(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each look at the clock is an hour after the last."""
    began = time.time()
    hours = iter(range(10_000))

    class Clock(datetime):
        @classmethod
        def now(cls, tz: object = None) -> datetime:
            return datetime.fromtimestamp(began + 3600 * next(hours), tz)

    monkeypatch.setattr("app.files.provenance.datetime", Clock)


@pytest.mark.usefixtures("passing_hours")
@pytest.mark.parametrize(
    ("flags", "files"),
    [
        (("render", "--depth"), 8),
        (("render", "--depth", "--with", "gl"), 8),
        (("render", "--view", "motion", "--with", "gl"), 2),
        (("render", "--transparent"), 2),
        (("export",), 2),
    ],
)
def test_a_repetition_writes_the_same_bytes(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli, flags: tuple[str, ...], files: int,
    gl_context: object,
) -> None:  # fmt: skip
    command, *rest = flags
    kind = "--ply" if command == "export" else "--out"
    for name in ("first", "second"):
        call = vesselsplat(command, runs["original"], kind, tmp_path / name, "--frames", 0, 5, *rest)
        assert (call.code, call.error) == (0, "")
    first, second = contents(tmp_path / "first"), contents(tmp_path / "second")
    assert len(first) == files
    assert first == second


def test_a_repeated_video_has_the_same_bytes(runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli) -> None:
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
        call = vesselsplat("export", runs["original"], "--video", tmp_path / name / "a.mp4", "--cameras",
                           tmp_path / name / "cameras.json", "--frames", 0, 1, 2)  # fmt: skip
        assert call.code == 0, call.error
    assert contents(tmp_path / "first") == contents(tmp_path / "second")
