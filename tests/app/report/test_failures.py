from __future__ import annotations

from pathlib import Path
from types import ModuleType

import pytest

from app.report.bench import Bench, Clock
from app.report.measures import paper, training
from app.report.runs import Runs
from renderer.train.trainer import TrainingError


@pytest.mark.parametrize("part", [training, paper])
def test_a_run_that_fails_is_told_and_the_others_go_on(
    part: ModuleType, clip_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(*_: object) -> None:
        raise TrainingError("the loss is not finite, at iteration 7: lower the learning rates")

    monkeypatch.setattr(Runs, "trained", failing)
    section = part.measure(Bench(clip_path, (), tmp_path, print), Clock.of(600))
    told = [line for line in section.not_measured if "the loss is not finite, at iteration 7" in line]
    assert any(line.startswith(("static", "VesselSplat")) for line in told)
    assert len(told) >= len(paper.METHODS) * len(training.INPUTS)
    assert section.tables
