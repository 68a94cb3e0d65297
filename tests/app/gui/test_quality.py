"""The quality dial: words for iterations, and an expected time only where one was measured."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from app.gui.state.reconstruction import OWN, QUALITIES, Reconstruction, expected_seconds, quality_of
from app.runs.train_run import TrainRequest
from renderer.train.config import TrainConfig
from renderer.train.events import Progress


def test_every_word_is_of_its_iterations_and_the_default_is_standard() -> None:
    assert all(quality_of(steps) == name for name, steps in QUALITIES.items())
    assert quality_of(TrainConfig().iterations) == "Standard"
    assert quality_of(1234) == OWN


def test_the_time_is_that_of_the_run_shown_in_proportion() -> None:
    config = TrainConfig(iterations=3000)
    request = TrainRequest(clip_path=Path("clip"), run_path=Path("run"), config=config)
    run = Reconstruction(config=config, request=request)
    assert expected_seconds(run) is None
    run.progress = Progress(1500, 3000, 0.1, 30.0, 60.0, 60.0, 100)
    assert expected_seconds(run) == pytest.approx(120)
    run.config = replace(config, iterations=500)
    assert expected_seconds(run) == pytest.approx(20)
    run.progress = replace(run.progress, wall_seconds=75.0)
    assert expected_seconds(run) == pytest.approx(20 + 15)
    run.input = "both in turn"
    assert expected_seconds(run) == pytest.approx(2 * (20 + 15))
    run.config = replace(config, method="deform3dgs")
    assert expected_seconds(run) is None
