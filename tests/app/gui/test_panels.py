"""The draw functions of the other panels: what they show, and what a click does."""

from __future__ import annotations

from dataclasses import replace

import pytest
from imgui_bundle import ImVec2, imgui, implot

from app.gui.actions import enhancement_actions, history_actions, job_actions, path_actions
from app.gui.panels import reconstruction
from app.gui.panels.cameras import draw_cameras
from app.gui.panels.enhancement import draw_enhancement
from app.gui.panels.menus import SEPARATOR, fitting
from app.gui.panels.reconstruction import (
    CONTINUES,
    FIRST_USE,
    STARTS_OVER,
    WAITS_FOR_EDITS,
    draw_reconstruction,
    round_ticks,
)
from app.gui.panels.timeline import draw_timeline
from app.gui.panels.welcome import CHOICES, draw_welcome
from app.gui.state.app_state import AppState
from app.gui.state.run_words import COMPILING, FIRST_STEP, doing
from app.gui.style.widgets import seconds
from app.runs.progress_log import TrainingLog
from assets import phantom_path
from enhance import EnhanceParams
from renderer.gaussians import DynamicGaussians
from renderer.train.events import Evaluated, Preparing, Progress, Started
from tests.app.gui.conftest import start_live
from tests.app.gui.ui import Draw, Shown, Ui, compare, view3d


def test_without_a_clip_there_is_something_to_do(
    ui: Ui, state: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The third of the buttons opens the built-in clip."""
    state.source.clip = None
    spots: list[tuple[float, float]] = []

    def seen(label: str, *rest: object) -> bool:
        pressed = bool(button(label, *rest))
        low = imgui.get_item_rect_min()
        spots.append((low.x + 20, low.y + 5))
        return pressed

    button = imgui.button
    monkeypatch.setattr(imgui, "button", seen)
    draw: Draw = lambda: draw_welcome(state, Shown())  # noqa: E731
    ui.frame(draw)
    assert len(spots) == len(CHOICES)
    ui.drag(draw, spots[-1], spots[-1])
    assert state.source.opening is not None
    assert state.source.opening.path == phantom_path()


def test_dragging_a_slider_is_live_and_one_undo(ui: Ui, opened: AppState) -> None:
    spots: dict[str, tuple[float, float]] = {}

    def draw() -> None:
        draw_enhancement(opened, Shown())
        window = imgui.get_window_pos()
        spots["strength"] = (window.x + 300, window.y + 10 + 2.5 * imgui.get_frame_height_with_spacing())
        if not imgui.is_any_item_active():
            enhancement_actions.settle_params(opened)

    ui.frame(draw)
    start = spots["strength"]
    ui.drag(draw, start, (start[0] + 200, start[1]))
    moved = opened.enhancement.params
    assert moved.strength != EnhanceParams().strength
    assert replace(moved, strength=1.0) == EnhanceParams()
    assert len(opened.enhancement.past) == 2
    history_actions.undo(opened)
    assert opened.enhancement.params == EnhanceParams()


@pytest.mark.parametrize(
    "status", ["none", "starting", "running", "paused", "finished", "failed", "cancelled", "elsewhere"]
)
def test_the_reconstruction_panel_draws_every_state(ui: Ui, opened: AppState, status: str) -> None:
    run = opened.runs.reconstruction
    run.status, run.input, run.failure = status, "enhanced", "out of memory"  # type: ignore[assignment]
    run.started = Started(0, 100, 30, ())
    run.progress = Progress(50, 100, 0.1, 25.0, 61.0, 3700.0, 30_000)
    run.told = TrainingLog(
        (Progress(1, 100, 0.5, 10.0, 1.0, 99.0, 20_000), run.progress),
        (Evaluated(50, 22.0), Evaluated(100, 24.0, 0.5)),
    )
    run.warnings = ["a warning"]
    ui.frame(lambda: draw_reconstruction(opened))
    ui.frame(lambda: draw_reconstruction(opened))


def test_what_waits_for_edits_stands_below_what_became_of_the_run(
    ui: Ui, opened: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    monkeypatch.setattr(job_actions, "waits_for_edits", lambda state: True)
    for name in ("note", "muted"):
        monkeypatch.setattr(reconstruction, name, lambda text, *rest: said.append(text))
    run = opened.runs.reconstruction
    run.status, run.progress = "cancelled", Progress(50, 100, 0.1, 25.0, 61.0, 3700.0, 30_000)
    ui.frame(lambda: reconstruction.draw_reconstruction(opened))
    (took,) = (text for text in said if text.endswith(("training", "in total")))
    at = said.index(took)
    assert said[at - 1 : at + 2] == [doing(opened), took, WAITS_FOR_EDITS]


def test_the_queue_stands_above_the_diagrams_of_what_is_trained(
    ui: Ui, opened: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    run, drawn = opened.runs.reconstruction, []
    run.status, run.progress = "running", Progress(50, 100, 0.1, 25.0, 61.0, 3700.0, 30_000)
    run.told = TrainingLog((Progress(1, 100, 0.5, 10.0, 1.0, 99.0, 20_000), run.progress), ())
    unfold, plot = imgui.tree_node, implot.begin_plot
    monkeypatch.setattr(imgui, "tree_node", lambda label: drawn.append(label) or unfold(label))
    monkeypatch.setattr(implot, "begin_plot", lambda name, *rest: drawn.append(name) or plot(name, *rest))
    ui.frame(lambda: draw_reconstruction(opened))
    assert drawn[:2] == ["Queue another###another", "##PSNR"]


def test_what_became_of_a_run_is_in_sight_when_it_ends(
    ui: Ui, opened: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However far the choices were scrolled to begin it."""
    run, scrolled = opened.runs.reconstruction, []
    monkeypatch.setattr(reconstruction, "_draw_next", lambda state: scrolled.append(imgui.get_scroll_y()))
    draw: Draw = lambda: draw_reconstruction(opened)  # noqa: E731
    monkeypatch.setattr(reconstruction, "_draw_messages", lambda run: imgui.dummy(ImVec2(0, 3000)))
    for _ in range(3):
        ui.frame(draw)
    ui.scroll(draw, (400, 300), -20)
    for _ in range(3):
        ui.frame(draw)
    assert scrolled[-1] > 0
    run.status = "running"
    ui.frame(draw)
    run.status = "finished"
    for _ in range(3):
        ui.frame(draw)
    assert scrolled[-1] == 0


def test_a_warning_names_no_flag_of_the_command_line(
    ui: Ui, opened: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    monkeypatch.setattr(reconstruction, "capital", lambda text: said.append(text) or text)
    run = opened.runs.reconstruction
    run.status, run.started = "running", Started(0, 100, 30, ())
    run.progress = Progress(50, 100, 0.1, 25.0, 61.0, 3700.0, 30_000)
    run.warnings = ["lengths have no scale (--baseline gives it in mm)", "estimated (a lamp at the camera)"]
    ui.frame(lambda: reconstruction.draw_reconstruction(opened))
    assert "lengths have no scale" in said
    assert "estimated (a lamp at the camera)" in said


def test_the_status_bar_says_as_much_as_there_is_room_for(ui: Ui) -> None:
    said: list[str] = []

    def draw() -> None:
        said.extend(fitting(["the clip", "its speed"], room) for room in (1e4, 120.0, 1.0))

    ui.frame(draw)
    assert said == [f"the clip{SEPARATOR}its speed", "the clip", ""]


def test_the_wait_before_the_first_step_has_words(ui: Ui, opened: AppState) -> None:
    run = opened.runs.reconstruction
    run.status = "running"
    assert doing(opened) == FIRST_STEP
    ui.frame(lambda: draw_reconstruction(opened))
    run.progress = Progress(1, 100, 0.1, 25.0, 1.0, 99.0, 30_000)
    assert doing(opened) != FIRST_STEP


def test_while_it_compiles_the_panel_counts_the_seconds(
    ui: Ui, opened: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    run, said = opened.runs.reconstruction, list[str]()
    run.status, run.started_at, opened.window.now = "running", 10.0, 195.0
    monkeypatch.setattr(reconstruction, "note", lambda text, color=None: said.append(text))
    ui.frame(lambda: draw_reconstruction(opened))
    assert said == [COMPILING, f"{FIRST_USE} 3 min 05 s so far."]


@pytest.mark.parametrize("total", [0, 27])
def test_the_panel_shows_what_is_prepared(ui: Ui, opened: AppState, total: int) -> None:
    run, shown = opened.runs.reconstruction, []
    run.status, run.preparing = "starting", Preparing("matching left and right images", 3, total, 2.0, None)

    def draw() -> None:
        top = imgui.get_cursor_pos_y()
        draw_reconstruction(opened)
        shown.append(imgui.get_cursor_pos_y() - top)

    ui.frame(draw)
    run.preparing = None
    ui.frame(draw)
    assert shown[0] > shown[1]


def test_the_panels_draw_at_the_very_start(ui: Ui, state: AppState) -> None:
    state.source.clip = None
    ui.frame(lambda: draw_enhancement(state, Shown()))
    ui.frame(lambda: draw_reconstruction(state))
    ui.frame(lambda: draw_timeline(state, Shown()))
    ui.frame(lambda: view3d(state))
    ui.frame(compare(state, Shown()))


@pytest.mark.parametrize(
    ("duration", "text"),
    [(0.4, "0 s"), (42, "42 s"), (185, "3 min 05 s"), (4320, "1 h 12 min"), (59.6, "1 min 00 s")],
)
def test_durations_are_said_as_people_do(duration: float, text: str) -> None:
    assert seconds(duration) == text


def test_the_cameras_panel_draws_every_state(ui: Ui, opened: AppState, model: DynamicGaussians) -> None:
    draw: Draw = lambda: draw_cameras(opened)  # noqa: E731
    ui.frame(draw)
    start_live(opened, model)
    ui.frame(draw)
    for _ in range(2):
        path_actions.save_view(opened)
        path_actions.add_keyframe(opened)
        ui.frame(draw)
    path_actions.toggle_path(opened)
    ui.frame(draw)


@pytest.mark.parametrize("has_checkpoint", [False, True])
def test_continue_says_whether_a_run_goes_on_or_starts_over(
    ui: Ui, opened: AppState, monkeypatch: pytest.MonkeyPatch, has_checkpoint: bool
) -> None:
    run, said = opened.runs.reconstruction, dict[str, str]()
    run.status, run.has_checkpoint = "cancelled", has_checkpoint

    def noted(label: str, act: object, text: str = "", **others: object) -> None:
        said[label] = text

    monkeypatch.setattr(reconstruction, "button", noted)
    ui.frame(lambda: draw_reconstruction(opened))
    assert said["Continue"] == (CONTINUES if has_checkpoint else STARTS_OVER)


def test_the_curves_count_iterations_in_round_steps() -> None:
    ticks = {1: [0], 10: [0, 2, 4, 6, 8], 150: [0, 50, 100], 3000: [0, 1000, 2000], 30000: [0, 10000, 20000]}
    assert {most: round_ticks(most) for most in ticks} == ticks
    assert round_ticks(1020) == [0, 500]
    assert round_ticks(0) == [0]
