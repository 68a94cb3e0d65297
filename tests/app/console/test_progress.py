"""Progress: what was done before the work began says nothing about the time left."""

from __future__ import annotations

import re

import pytest
from rich.cells import cell_len
from rich.console import Console
from rich.progress import Progress

from app.console.progress import _bar, print_measures, progress


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """The time, to be set."""
    now = [0.0]
    monkeypatch.setattr("app.console.progress.time.monotonic", lambda: now[0])
    return now


@pytest.mark.parametrize("start", [0, 900])
def test_time_left_is_that_of_the_work_since_the_start(
    capsys: pytest.CaptureFixture[str], clock: list[float], start: int
) -> None:
    with progress("train", 1000) as report:
        report(start, "")
        clock[0] = 20.0
        report(start + 50, "[loss] 0.1")
    left = (1000 - start - 50) / 50 * 20.0
    assert capsys.readouterr().err == f"train {start + 50}/1000, {left:.0f} s left [loss] 0.1\n"


def test_the_first_unit_alone_says_nothing(capsys: pytest.CaptureFixture[str], clock: list[float]) -> None:
    with progress("enhance", 2) as report:
        clock[0] = 60.0
        report(1, "one.png")
    assert capsys.readouterr().err == ""


def test_the_bar_counts_from_the_start() -> None:
    now = [0.0]
    with Progress(console=Console(quiet=True), get_time=lambda: now[0], auto_refresh=False) as bar:
        report = _bar(bar, "train", 1000)
        report(900, "")
        for step in range(1, 5):
            now[0] = 10.0 * step
            report(900 + 10 * step, "")
        assert bar.tasks[0].completed == 940
        assert bar.tasks[0].time_remaining == pytest.approx(60, rel=0.35)


def test_no_line_comes_before_its_time(capsys: pytest.CaptureFixture[str], clock: list[float]) -> None:
    with progress("draw", 100) as report:
        for done in range(100):
            clock[0] = done * 0.3
            report(done, "")
    shown = re.findall(r"draw (\d+)/100", capsys.readouterr().err)
    assert [int(done) for done in shown] == [34, 68]


@pytest.mark.parametrize("width", [60, 100, 400])
def test_a_table_that_is_too_wide_goes_on_below_with_nothing_cut(
    width: int, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.console.progress.WIDTH", width)
    monkeypatch.setenv("COLUMNS", "20")
    head = ("image", *(f"measure_number_{place}" for place in range(12)))
    rows = [(name, *(f"{name}{place}" for place in range(12))) for name in ("first.png", "眼底照片.png")]
    print_measures(head, rows, ("mean", *"abcdefghijkl"))
    printed = capsys.readouterr().out
    assert "…" not in printed
    assert max(cell_len(line) for line in printed.splitlines()[:-1]) <= width
    for row in (*rows, head):
        assert all(cell in printed for cell in row)
    assert printed.count("mean ") == printed.count("image ")
