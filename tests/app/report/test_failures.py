from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import NoReturn

import pytest

from app.errors import UserError
from app.report.bench import Bench, Clock
from app.report.measures import paper, training
from app.report.runs import Runs, schedule
from renderer.sources import open_clip
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


@pytest.mark.parametrize(
    ("where", "fault", "said"),
    [
        ("train", TrainingError("the loss is not finite"), "the loss is not finite"),
        (
            "planned_in",
            UserError("expected 9.0 GB of free memory, got 1.0 GB: {run}"),
            "expected 9.0 GB of free memory, got 1.0 GB",
        ),
    ],
)
def test_a_training_that_fails_is_one_for_the_parts_whatever_it_lacks(
    where: str, fault: Exception, said: str, clip_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clip = open_clip(clip_path)
    config = schedule(clip, "static")
    runs = Runs(clip_path, clip, tmp_path, print, _warmed={"static"})

    def failing(*given: object, **_: object) -> NoReturn:
        raise type(fault)(str(fault).format(run=given[0]))

    monkeypatch.setattr(f"app.runs.train_run.{where}", failing)
    with pytest.raises(TrainingError) as caught:
        runs.trained(config)
    assert str(caught.value) == said
