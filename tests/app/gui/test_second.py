"""A second reconstruction beside the first."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from app.gui.actions import actions, camera_actions, run_actions, second_actions
from app.gui.commands import recent_commands
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels
from app.gui.update.wishes import SLOW_VIEW, second_wish, view_wish
from app.gui.work.settings import Places
from app.scenes.drawer import View
from app.scenes.view_kinds import ViewKind
from app.scenes.view_request import FrameImage, FrameRequest
from assets import phantom_path
from renderer.gaussians import DynamicGaussians
from tests.app.gui.conftest import SIZE
from tests.app.gui.driver import Driver, is_settled, wait
from tests.app.gui.settling import settle
from tests.app.gui.test_opening import make_run


def test_a_run_is_opened_and_drawn_beside_the_first(
    seen: AppState, model: DynamicGaussians, tmp_path: Path
) -> None:
    channels = Channels()
    actions.toggle_unobserved(seen)  # Of a preview, which the first one is, it is not known.
    run = make_run(tmp_path / "run-2", phantom_path(), model)
    second_actions.open_second(seen, run.path)
    settle(seen, channels)
    second = seen.scene.second
    assert second.model is not None
    assert second.model.name == "run-2"
    assert seen.scene.view is not None
    assert second.view is not None
    assert second.view.request == replace(seen.scene.view.request, scene=second.model)
    np.testing.assert_array_equal(
        second.view.image, seen.scene.view.image
    )  # The same model: the same picture.
    camera_actions.turn(seen, 0.3, 0.0)
    settle(seen, channels)
    assert second.view.request.camera == seen.scene.view.request.camera
    second_actions.close_second(seen)
    assert seen.scene.second.model is None
    assert seen.second_request is None


def test_what_is_no_reconstruction_is_one_line_and_leaves_what_is_there(
    seen: AppState, model: DynamicGaussians, tmp_path: Path
) -> None:
    channels = Channels()
    second_actions.open_second(seen, make_run(tmp_path / "whole", phantom_path(), model).path)
    settle(seen, channels)
    shown = seen.scene.second.model
    unfinished = make_run(tmp_path / "unfinished", phantom_path(), None).path
    for path in (tmp_path / "nothing", phantom_path(), unfinished):
        second_actions.open_second(seen, path)
        settle(seen, channels)
        assert seen.window.banner is not None
        assert str(path) in seen.window.banner.message
        assert "\n" not in seen.window.banner.message
        assert seen.scene.second.model is shown
        assert seen.scene.second.opening is None


def test_only_what_has_a_model_and_is_not_shown_is_offered(
    seen: AppState, model: DynamicGaussians, tmp_path: Path
) -> None:
    whole = make_run(tmp_path / "whole", phantom_path(), model).path
    other = make_run(tmp_path / "other", phantom_path(), model).path
    empty = make_run(tmp_path / "empty", phantom_path(), None).path
    splats = tmp_path / "splats.ply"
    splats.write_bytes(b"")
    recent = tuple(map(str, (whole, phantom_path(), empty, tmp_path / "gone.ply", splats, other)))
    seen.settings = replace(seen.settings, recent=recent)
    channels = Channels()
    assert second_actions.offered(seen) == ()  # Not looked up yet.
    settle(seen, channels)
    channels.beside.run_waiting()
    settle(seen, channels)
    assert second_actions.offered(seen) == (whole, splats, other)
    second_actions.open_second(seen, whole)
    settle(seen, channels)
    assert second_actions.offered(seen) == (splats, other)
    assert [command.text for command in recent_commands.beside(seen)] == [str(splats), str(other)]
    seen.scene.model = None
    assert recent_commands.beside(seen) == ()


@pytest.mark.display
def test_a_run_of_the_list_is_opened_beside_and_closed_again(places: Places, model: DynamicGaussians) -> None:
    driver = Driver(places)
    state = driver.state
    runs = [make_run(places.runs / name, phantom_path(), model).path for name in ("first", "second")]
    make_run(places.runs / "third", phantom_path(), None)
    actions.open_path(state, runs[0])

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state) and state.scene.model is not None, "the first run")
        ctx.window_focus("//Runs")
        wait(ctx, lambda: state.runs.found is not None and len(state.runs.found.runs) == 3, "the list")
        listed = {run.path.name: run for run in state.runs.found.runs} if state.runs.found else {}
        assert "one that is shown" in run_actions.why_not_beside(state, listed["first"])
        assert "no model" in run_actions.why_not_beside(state, listed["third"])
        for name in ("first", "third"):  # Greyed.
            ctx.item_click(f"//Runs/{name}/###beside")
        ctx.yield_(3)
        assert state.scene.second.opening is None
        ctx.item_click("//Runs/second/###beside")
        wait(ctx, lambda: state.second_request is not None, "the second view")
        assert state.view_request is not None
        assert state.second_request is not None
        assert state.second_request.camera == state.view_request.camera
        assert state.scene.model is not None
        assert state.scene.model.name == "first"
        ctx.item_click("//Runs/second/###beside")
        wait(ctx, lambda: state.scene.second.model is None, "none again")

    driver.run(drive)


def test_without_a_first_there_is_no_second(state: AppState, tmp_path: Path) -> None:
    second_actions.open_second(state, tmp_path)
    assert state.scene.second.opening is None


def test_two_views_are_reduced_when_they_are_slow_together(seen: AppState) -> None:
    request = seen.view_request
    assert request is not None
    assert seen.scene.model is not None
    view = View(request, np.zeros((*SIZE[::-1], 3), np.uint8), 0.7 * SLOW_VIEW)
    seen.scene.view, seen.scene.dragged = view, True
    wanted = view_wish(seen)
    assert wanted is not None
    assert not wanted.reduced
    seen.scene.second.model, seen.scene.second.view = replace(seen.scene.model), view
    wanted = view_wish(seen)
    assert wanted is not None
    assert wanted.reduced


def test_a_second_of_other_frames_has_no_difference_to_the_firsts_frame(seen: AppState) -> None:
    first = seen.plain_view_request
    assert first is not None
    assert seen.scene.model is not None
    assert seen.source.clip is not None
    reference = FrameImage(FrameRequest(seen.source.clip, 0), np.zeros((*SIZE[::-1], 3), np.uint8))
    wanted = first.of_kind("difference", reference)
    assert seen.scene.beside(wanted) is None
    seen.scene.second.model = replace(seen.scene.model)
    same = seen.scene.beside(wanted)
    assert same == replace(wanted, scene=seen.scene.second.model)
    for other in (
        replace(seen.scene.model, first=2),
        replace(seen.scene.model, cameras=seen.scene.model.cameras[:3]),
    ):
        seen.scene.second.model = other
        beside = seen.scene.beside(wanted)
        assert beside is not None
        assert (beside.kind, beside.reference) == ("color", None)
        assert (beside.time, beside.camera) == (wanted.time, wanted.camera)
        depth = seen.scene.beside(first.of_kind("depth"))
        assert depth is not None
        assert depth.kind == "depth"


def test_the_processor_draws_the_second_view_as_the_window_asks_for_it(seen: AppState) -> None:
    """Also where the second one has other frames, whose difference to the first one's frame says nothing."""
    channels = Channels()
    assert seen.scene.model is not None
    assert seen.source.clip is not None
    reference = FrameImage(FrameRequest(seen.source.clip, 0), np.zeros((*SIZE[::-1], 3), np.uint8))
    seen.scene.viewer.snapped, seen.scene.viewer.frame_image = True, reference
    kinds: tuple[ViewKind, ...] = ("color", "difference")
    for shown in (replace(seen.scene.model), replace(seen.scene.model, first=2)):
        seen.scene.second.model = shown
        for seen.scene.kind in kinds:
            wanted = seen.plain_view_request
            assert wanted is not None
            assert wanted.kind == seen.scene.kind
            channels.second.want(second_wish(seen))
            assert channels.second.asked == seen.scene.beside(wanted) is not None


def test_a_new_session_has_no_second_view(seen: AppState, model: DynamicGaussians, tmp_path: Path) -> None:
    seen.runs.reconstruction = type(seen.runs.reconstruction)()
    assert seen.scene.model is not None
    seen.scene.second.model = seen.scene.model
    run = make_run(tmp_path / "run", phantom_path(), model)
    actions.open_path(seen, run.path)
    settle(seen, Channels())
    assert seen.scene.model.name == "run"
    assert seen.scene.second.model is None
