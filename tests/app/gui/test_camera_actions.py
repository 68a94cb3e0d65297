from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from app.gui.actions import actions, camera_actions
from app.gui.state.app_state import AppState
from app.gui.views.measurement import Located
from app.gui.work.selecting import PickRequest, pick
from app.scenes.view_request import ViewRequest
from tests.app.gui.conftest import make_model

Act = Callable[[AppState], None]


def request(state: AppState) -> ViewRequest:
    assert state.view_request is not None
    return state.view_request


MOVES: dict[str, Act] = {
    "turn": lambda state: camera_actions.turn(state, 0.2, 0.1),
    "pan": lambda state: camera_actions.pan(state, 5, 3),
    "zoom": lambda state: camera_actions.zoom(state, 1.5),
}


@pytest.mark.parametrize("move", MOVES.values(), ids=MOVES)
def test_home_is_the_clip_s_camera_again(seen: AppState, move: Act) -> None:
    start = request(seen)
    assert start.camera == seen.scene.model.cameras[0]  # type: ignore[union-attr]
    move(seen)
    assert request(seen) != start
    camera_actions.reset_view(seen)
    assert request(seen) == start
    assert seen.scene.viewer.pivot is None


def test_a_picked_point_becomes_the_centre_and_stays_on_its_pixel(seen: AppState) -> None:
    camera_actions.ask_point(seen, request(seen), (24, 20), "orbit")
    wish = seen.scene.viewer.pick
    assert wish is not None
    (answer,) = pick(wish)
    assert answer is not None
    camera_actions.take_point(seen, wish, answer)
    assert seen.scene.viewer.pivot == answer.point
    assert answer.point[2] == pytest.approx(50.0, abs=1e-3)  # The sheet of the model.
    for move in (MOVES["turn"], MOVES["zoom"]):
        move(seen)
        (at,), _ = request(seen).camera.project(np.array([answer.point]))
        assert at == pytest.approx((24.5, 20.5), abs=1e-6)


def test_nothing_is_picked_beside_the_tissue_or_of_a_view_that_is_gone(seen: AppState) -> None:
    camera_actions.ask_point(seen, request(seen), (-3, 2), "orbit")
    wish = seen.scene.viewer.pick
    assert wish is not None
    (answer,) = pick(wish)
    assert answer is None
    camera_actions.take_point(seen, wish, answer)
    assert seen.scene.viewer.pivot is None
    assert seen.window.toast is not None
    assert seen.scene.model is not None
    seen.scene.model = replace(seen.scene.model, model=make_model())
    camera_actions.take_point(seen, wish, Located((1.0, 2.0, 3.0)))
    assert seen.scene.viewer.pivot == (1.0, 2.0, 3.0)  # A newer preview of the same tissue.
    camera_actions.reset_view(seen)
    seen.scene.model = replace(seen.scene.model, cameras=seen.scene.model.cameras[:1])
    camera_actions.take_point(seen, wish, Located((1.0, 2.0, 3.0)))
    assert seen.scene.viewer.pivot is None


def test_flight_moves_at_its_speed_and_takes_the_centre_along(seen: AppState) -> None:
    camera_actions.fly(seen, 0, 0, 1, 0.05)
    assert seen.scene.viewer.free is None  # Not in flight yet.
    camera_actions.toggle_flight(seen)
    camera_actions.fly(seen, 0, 0, 1, 0.05)
    step = seen.scene.viewer.speed * 50.0 * 0.05
    assert request(seen).camera.position == pytest.approx((0, 0, step))
    assert seen.scene.viewer.pivot == pytest.approx((0, 0, 50 + step))
    camera_actions.turn(seen, 0.3, 0.0)
    assert request(seen).camera.position == pytest.approx((0, 0, step))
    speed = seen.scene.viewer.speed
    camera_actions.zoom(seen, 2.0)
    assert seen.scene.viewer.speed == pytest.approx(2 * speed)
    camera_actions.toggle_flight(seen)
    before = request(seen).camera
    camera_actions.turn(seen, 0.5, 0.0)
    (at,), _ = before.project(np.array([seen.scene.viewer.pivot]))
    (now,), _ = request(seen).camera.project(np.array([seen.scene.viewer.pivot]))
    assert now == pytest.approx(at)


def test_a_pause_of_the_window_is_no_leap(seen: AppState) -> None:
    camera_actions.toggle_flight(seen)
    camera_actions.fly(seen, 1, 0, 0, 60.0)
    assert (
        request(seen).camera.position[0]
        <= seen.scene.viewer.speed * 50.0 * camera_actions.LONGEST_STEP + 1e-9
    )


def test_the_free_view_stays_while_the_clip_s_time_goes_on(seen: AppState) -> None:
    camera_actions.turn(seen, 0.2, 0.0)
    before = request(seen).camera
    actions.seek(seen, 3)
    assert request(seen).camera == before


def test_wishes_are_by_value_and_need_a_view(state: AppState) -> None:
    for move in MOVES.values():
        move(state)
    camera_actions.toggle_flight(state)
    assert (state.scene.viewer.pick, state.scene.viewer.free, state.scene.viewer.flying) == (
        None,
        None,
        False,
    )


def test_two_wishes_for_a_pixel_are_two(seen: AppState) -> None:
    assert PickRequest(request(seen), (1, 1), "orbit") != PickRequest(request(seen), (1, 1), "orbit")


@pytest.mark.parametrize("move", MOVES.values(), ids=MOVES)
def test_a_snapped_view_is_the_clip_s_camera_exactly_until_it_is_moved(seen: AppState, move: Act) -> None:
    seen.scene.size = (301, 77)
    assert seen.source.clip is not None
    assert request(seen).camera != seen.source.clip.cameras[2]
    actions.seek(seen, 2)
    move(seen)
    camera_actions.toggle_snap(seen)
    assert request(seen).camera == seen.source.clip.cameras[2]
    assert request(seen).time == seen.source.clip.times[2]
    assert seen.frame_request is not None
    assert (seen.frame_request.clip, seen.frame_request.frame) == (seen.source.clip, 2)
    move(seen)
    assert not seen.scene.viewer.snapped
    assert request(seen).camera.width == 301
    assert seen.frame_request is None


def test_a_snapped_view_between_two_frames_is_of_the_nearer_one(seen: AppState) -> None:
    actions.toggle_link(seen)
    actions.seek_view(seen, 3.4 / 6)
    camera_actions.toggle_snap(seen)
    assert request(seen).time == 3 / 6
    assert seen.frame_request is not None
    assert seen.frame_request.frame == 3


def test_without_the_model_s_own_clip_there_is_no_frame(seen: AppState) -> None:
    assert seen.source.clip is not None
    other = seen.source.clip.cameras[0].resized(10, 10)
    seen.source.clip = replace(seen.source.clip, cameras=(other,) * 6)
    camera_actions.toggle_snap(seen)
    assert not seen.scene.viewer.snapped


def test_the_frame_s_share_stays_between_none_and_all(seen: AppState) -> None:
    for share, kept in ((-0.3, 0.0), (0.4, 0.4), (7.0, 1.0)):
        camera_actions.blend(seen, share)
        assert seen.scene.viewer.blend == kept
