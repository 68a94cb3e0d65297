"""The quality dial: words for iterations, and an expected time only where one was measured."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from imgui_bundle import ImVec2, imgui

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


@pytest.fixture
def ends(monkeypatch: pytest.MonkeyPatch) -> dict[str, ImVec2]:
    """Of the field of iterations with its buttons, as drawn last."""
    found, draw = dict[str, ImVec2](), imgui.input_int

    def seen(*given: Any) -> tuple[bool, int]:
        drawn = draw(*given)
        found.update(low=imgui.get_item_rect_min(), high=imgui.get_item_rect_max())
        return drawn

    monkeypatch.setattr(imgui, "input_int", seen)
    return found


def click(ui: Ui, state: AppState, at: tuple[float, float], times: int) -> None:
    """So many in quick succession."""
    show = partial(draw_choices, state)
    for _ in range(times):
        ui.drag(show, at, at)
    ui.frame(show)


def test_quick_clicks_on_a_button_of_the_iterations_are_so_many_steps(
    ui: Ui, opened: AppState, ends: dict[str, ImVec2]
) -> None:
    ui.frame(partial(draw_choices, opened))
    low, high = ends["low"], ends["high"]
    click(ui, opened, (high.x - 5, (low.y + high.y) / 2), 3)
    assert opened.runs.reconstruction.config.iterations == TrainConfig().iterations + 300


def test_a_double_click_chooses_the_number_of_iterations_to_type_over(
    ui: Ui, opened: AppState, ends: dict[str, ImVec2]
) -> None:
    run, show = opened.runs.reconstruction, partial(draw_choices, opened)
    run.config = replace(run.config, iterations=700)
    ui.frame(show)
    low, high = ends["low"], ends["high"]
    click(ui, opened, (low.x + 10, (low.y + high.y) / 2), 2)
    assert run.config.iterations == 700
    ui.io.add_input_characters_utf8("42")
    ui.frame(show)
    ui.press(show, imgui.Key.enter)
    assert run.config.iterations == 42
