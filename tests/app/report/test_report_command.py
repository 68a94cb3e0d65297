from __future__ import annotations

import json
from pathlib import Path

import pytest

from app.report.bench import PARTS, Bench, Clock
from app.report.section import Section
from tests.app.conftest import Cli


def test_a_report_holds_page_and_figures_of_the_parts_asked_for(
    vesselsplat: Cli, clip_path: Path, tmp_path: Path
) -> None:
    out = tmp_path / "deep" / "report"
    call = vesselsplat(
        "report", "--clip", clip_path, "--out", out, "--parts", "enhancement", "--budget", "1min",
        "--error", "100",
    )  # fmt: skip
    assert call.code == 0, call.error
    assert sorted(path.name for path in out.iterdir()) == ["report.html", "report.json"]
    report = json.loads((out / "report.json").read_text())
    assert list(report["parts"]) == ["enhancement"]
    assert report["machine"]["packages"]["numpy"]
    assert "enhancement" in call.error
    assert "within 60 s" in call.out
    assert "at most 100" in call.out


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["--parts", "enhancement,nonsense"], "nonsense"),
        (["--budget", "soon"], "soon"),
        (["--budget", "0ms"], "0ms"),
        (["--clip", "nowhere/at/all"], "nowhere"),
        (["--scenes", "nowhere/at/all"], "nowhere"),
    ],
)
def test_mistakes_are_one_line_and_leave_nothing(
    vesselsplat: Cli, tmp_path: Path, arguments: list[str], word: str
) -> None:
    call = vesselsplat("report", "--out", tmp_path / "out", *arguments)
    assert call.code == 2
    assert word in call.error.splitlines()[-1]
    assert not any(tmp_path.iterdir())


def test_of_parts_that_measure_no_settings_it_is_told_that_there_is_no_advice(
    vesselsplat: Cli, tmp_path: Path, clip_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def measure(bench: Bench, clock: Clock) -> Section:
        return Section(title="Stability")

    monkeypatch.setattr("app.report.measures.stability.measure", measure)
    given = ("report", "--clip", clip_path, "--out", tmp_path / "out", "--parts", "stability")
    assert "no advice" not in vesselsplat(*given).out
    assert "no advice: none of these parts" in vesselsplat(*given, "--budget", "1min").out


def test_an_interruption_leaves_nothing(
    vesselsplat: Cli, tmp_path: Path, clip_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(bench: Bench, clock: Clock) -> Section:
        raise KeyboardInterrupt

    monkeypatch.setattr("app.report.measures.stability.measure", interrupted)
    call = vesselsplat("report", "--clip", clip_path, "--out", tmp_path / "out", "--parts", "stability")
    assert call.code == 130
    assert not any(tmp_path.iterdir())


def test_every_part_has_a_file_and_a_share() -> None:
    for part in PARTS:
        assert callable(part.measure)
        assert part.share > 0
