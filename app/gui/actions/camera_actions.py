"""What a user can have the 3D view show, and do with its camera, as functions on the state."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.state.scene import MAX_SPEED, MIN_SPEED
from app.gui.views.measurement import Located, Measurement
from app.gui.work.selecting import PickRequest, Purpose
from app.scenes.free_camera import FreeView, Vector, vector
from app.scenes.scene import Scene
from app.scenes.view_kinds import EXPLAINED, ViewKind
from app.scenes.view_request import ViewRequest

NO_SURFACE = "No surface under the pointer"
NOTHING_TO_MEASURE = (
    "Distances are measured on a reconstruction, and there is none: reconstruct a clip or open a run."
)
LONGEST_STEP = 0.1
"""Seconds: after a pause of the window, flight does not jump."""


def reset_view(state: AppState) -> None:
    """Back to the clip's own camera, and down from flight."""
    state.scene.cameras.playing = False
    state.scene.viewer = replace(state.scene.viewer, free=None, pivot=None, snapped=False, flying=False)


def toggle_snap(state: AppState) -> None:
    """The clip's camera to the pixel, under its frame; and back to filling the view."""
    if not state.has_frames:
        return
    viewer, state.scene.cameras.playing = state.scene.viewer, False
    state.scene.viewer = replace(viewer, free=None, pivot=None, flying=False, snapped=not viewer.snapped)


def blend(state: AppState, share: float) -> None:
    """Lay this share of the frame over a snapped view."""
    state.scene.viewer.blend = min(max(share, 0.0), 1.0)


def turn(state: AppState, yaw: float, pitch: float) -> None:
    """By radians around the orbit's centre; in flight on the spot."""
    if state.scene.model is None:
        return
    view = _leave(state, state.scene.model)
    if state.scene.viewer.flying:
        _carry(state, view.looked(yaw, pitch))
    else:
        state.scene.viewer.free = view.orbited(centre(state, state.scene.model), yaw, pitch)


def pan(state: AppState, x: float, y: float) -> None:
    """So that the orbit's centre follows the hand by so many pixels of the clip's frame."""
    if state.scene.model is not None:
        view = _leave(state, state.scene.model)
        state.scene.viewer.free = view.panned(centre(state, state.scene.model), x, y)


def zoom(state: AppState, factor: float) -> None:
    """Nearer to the orbit's centre for a factor above 1; in flight, faster."""
    viewer = state.scene.viewer
    if viewer.flying:
        viewer.speed = min(max(viewer.speed * factor, MIN_SPEED), MAX_SPEED)
    elif state.scene.model is not None:
        view = _leave(state, state.scene.model)
        viewer.free = view.zoomed(centre(state, state.scene.model), factor, state.scene.model.distance)


def toggle_flight(state: AppState) -> None:
    if state.scene.model is not None:
        state.scene.viewer.flying = not state.scene.viewer.flying
        _leave(state, state.scene.model)


def hold_flight(state: AppState, held: bool) -> None:
    """Remember whether a key of flight is held."""
    state.scene.viewer.moving = held


def fly(state: AppState, right: float, down: float, forward: float, seconds: float) -> None:
    """On in the camera's own directions, each -1, 0 or 1."""
    if state.scene.model is None or not state.scene.viewer.flying:
        return
    step = state.scene.viewer.speed * state.scene.model.distance * min(seconds, LONGEST_STEP)
    _carry(state, _leave(state, state.scene.model).flown(step * right, step * down, step * forward))


def toggle_measuring(state: AppState) -> None:
    """Clicks measure from now on, or turn and move the view alone again, without a distance shown."""
    if state.scene.model is not None:
        viewer = state.scene.viewer
        viewer.measuring, viewer.measurement = not viewer.measuring, Measurement()


def ask_point(state: AppState, request: ViewRequest, pixel: tuple[int, int], purpose: Purpose) -> None:
    """Wish for the surface point behind a pixel (column, row) of one of the views. Points that are measured
    are of one moment, at which playing ends."""
    if purpose != "orbit" and state.timeline.playing:
        state.timeline.playing = False
        actions.seek_view(state, request.time)
    state.scene.viewer.pick = PickRequest(request, pixel, purpose)


def take_point(state: AppState, request: PickRequest, point: Located | None) -> None:
    """The answer to a wish; of a view that is no longer shown, it is dropped."""
    models = [model for model in (state.scene.model, state.scene.second.model) if model is not None]
    if all(request.view.scene.cameras != model.cameras for model in models):
        return
    if point is None:
        actions.announce(state, NO_SURFACE)
    elif request.purpose == "orbit":
        state.scene.viewer.pivot, state.scene.viewer.flying = point.point, False
    else:
        viewer, view, goes_on = state.scene.viewer, request.view, request.purpose == "measure on"
        viewer.measurement = viewer.measurement.with_point(
            point, view.time, view.scene.identity, goes_on=goes_on
        )


def close_outline(state: AppState) -> None:
    """The measured line ends where it began, around an area."""
    state.scene.viewer.measurement = state.scene.viewer.measurement.as_outline()


def centre(state: AppState, model: Scene) -> Vector:
    """What the view turns around, in the world."""
    if state.scene.viewer.pivot is not None:
        return state.scene.viewer.pivot
    free = state.scene.viewer.free
    pose = (free.camera if free is not None else model.camera_at(state.time)).world_from_camera
    return vector(pose[:3, 3] + model.distance * pose[:3, 2])


def _leave(state: AppState, model: Scene) -> FreeView:
    """The view as it stands, no longer the clip's camera nor under its frame; its centre stays, too."""
    viewer = state.scene.viewer
    viewer.pivot, viewer.snapped = centre(state, model), False
    state.scene.cameras.playing = False
    viewer.free = viewer.free or FreeView.of(model.camera_at(state.time))
    return viewer.free


def _carry(state: AppState, view: FreeView) -> None:
    """To a view that takes the orbit's centre along, so that turning goes on around what is ahead."""
    viewer = state.scene.viewer
    assert viewer.pivot is not None
    assert viewer.free is not None
    seen = viewer.free.camera.camera_from_world @ [*viewer.pivot, 1.0]
    viewer.pivot = vector(np.asarray(view.camera.world_from_camera @ seen)[:3])
    viewer.free = view


def choices(state: AppState) -> tuple[ViewKind, ...]:
    """The views that this model has: without frames there is no difference to them, and a splat file per
    moment does not say what has moved."""
    model = state.scene.model
    lacks = {"motion", "surface"} if model is not None and model.is_series else set()
    lacks |= set() if state.has_frames else {"difference"}
    return tuple(kind for kind in EXPLAINED if kind not in lacks)


def choose_view(state: AppState, kind: ViewKind) -> None:
    """A difference is to the frame, so it is seen through the clip's camera."""
    state.scene.kind = kind
    if kind == "difference" and not state.scene.viewer.snapped:
        toggle_snap(state)


def next_view(state: AppState) -> None:
    if state.scene.model is not None:
        kinds = choices(state)
        now = kinds.index(state.scene.kind) if state.scene.kind in kinds else -1
        choose_view(state, kinds[(now + 1) % len(kinds)])
