"""The quality dial: words for iterations, and an expected time only where one was measured."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from app.gui.panels import reconstruction_choices
from app.gui.panels.reconstruction_choices import draw_choices
from app.gui.state.app_state import AppState
from app.gui.state.reconstruction import OWN, QUALITIES, Reconstruction, expected_seconds, quality_of
from app.runs.train_run import TrainRequest
from renderer.train.config import TrainConfig
from renderer.train.events import Progress
from tests.app.gui.ui import Ui


def test_every_word_is_of_its_iterations_and_the_default_is_standard() -> None:
    assert all(quality_of(steps) == name for name, steps in QUALITIES.items())
    assert quality_of(TrainConfig().iterations) == "Standard"
    assert quality_of(1234) == OWN


def test_the_time_is_that_of_the_run_shown_in_proportion() -> None:
    config = TrainConfig(iterations=3000)
    request = TrainRequest(clip_path=Path("clip"), run_path=Path("run"), config=config)
    run = Reconstruction(config=config, request=request)
    assert expected_seconds(run, 500) is None
    run.progress = Progress(1500, 3000, 0.1, 30.0, 60.0, 60.0, 100)
    assert expected_seconds(run, 3000) == pytest.approx(120)
    assert expected_seconds(run, 500) == pytest.approx(20)
    run.progress = replace(run.progress, wall_seconds=75.0)
    assert expected_seconds(run, 500) == pytest.approx(20 + 15)
    run.input = "both in turn"
    assert expected_seconds(run, 500) == pytest.approx(2 * (20 + 15))
    run.config = replace(config, method="deform3dgs")
    assert expected_seconds(run, 500) is None


def test_each_word_says_its_time(ui: Ui, opened: AppState, monkeypatch: pytest.MonkeyPatch) -> None:
    run, rows = opened.runs.reconstruction, []
    run.request = TrainRequest(clip_path=Path("clip"), run_path=Path("run"), config=run.config)
    run.progress = Progress(1500, 3000, 0.1, 30.0, 300.0, 300.0, 100)
    monkeypatch.setattr(
        reconstruction_choices,
        "choose_row",
        lambda name, now, shown, text: rows.append((name, dict(shown))) or now,
    )
    ui.frame(lambda: draw_choices(opened))
    assert dict(rows)["Quality"] == {
        "Draft": "Draft, about 2 min",
        "Standard": "Standard, about 10 min",
        "Fine": "Fine, about 20 min",
    }
