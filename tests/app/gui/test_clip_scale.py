"""Colours of depth and motion that mean the same at every moment of a clip."""

from __future__ import annotations

from pathlib import Path

from app.gui.actions import actions, camera_actions
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.gui.work.clip_scale import ScaleRequest, find_scale
from app.scenes.cpu_rendering import draw_on_cpu
from app.scenes.scene import open_scene
from app.scenes.view_kinds import ViewKind
from app.scenes.view_request import ViewRequest
from tests.app.gui.settling import served
from tests.app.gui.test_edit_actions import opened


def settled(state: AppState, run: Path) -> AppState:
    opened(state, run)
    state.scene.size = (64, 48)
    return state


def serve(state: AppState, channels: Channels) -> None:
    for _ in range(6):
        update(state, channels, 1.0)
        for channel in (*served(channels), *channels.of("second")):
            while channel.run_waiting():
                pass


def test_it_holds_what_the_clips_cameras_see_at_all_times(windowed_run: Path) -> None:
    scene = open_scene(windowed_run)
    kinds: tuple[ViewKind, ...] = ("depth", "motion")
    for kind in kinds:
        (found,) = find_scale(ScaleRequest(scene, kind))
        assert found.scale is not None
        for frame in (0, 50, 111):
            own = ViewRequest.of_frame(scene, frame).of_kind(kind).picture(draw_on_cpu).scale
            assert own is not None
            slack = 0.15 * (found.scale.high - found.scale.low)
            assert found.scale.low - slack <= own.low
            assert own.high <= found.scale.high + slack


def test_the_view_keeps_it_while_time_goes_on_and_not_for_a_free_camera(
    state: AppState, windowed_run: Path
) -> None:
    settled(state, windowed_run)
    channels, seen = Channels(), set()
    camera_actions.choose_view(state, "depth")
    serve(state, channels)
    for frame in (0, 50, 111):
        actions.seek(state, frame)
        serve(state, channels)
        assert state.scene.view is not None
        seen.add(state.scene.view.scale)
    (scale,) = seen
    assert scale is not None
    assert state.scene.steady_scale == scale
    camera_actions.turn(state, 0.2, 0.0)
    assert state.view_request is not None
    assert state.view_request.scale is None
    camera_actions.choose_view(state, "color")
    assert state.view_request.scale is None
    assert state.scene.steady_scale is None
