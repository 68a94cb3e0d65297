"""The record of a page for browsers, from a scene."""

from __future__ import annotations

from typing import Final

from app.exports.browser.page import PageWindow
from app.exports.browser.samples import Sampling
from app.exports.browser.tracks import tracks_of
from app.exports.records import BrowserModel
from app.files.records import extended
from app.scenes.scene import Scene
from renderer.camera import Camera
from renderer.model_windows import ModelWindow, windows_of

TOLERANCE: Final = 0.25
"""Pixels of the clip, of tissue at the middle distance."""
ROUNDING: Final = 0.25
"""Of the tolerance."""
MOST_VALUES: Final = 4096 * 2048
"""Of a kind, over all Gaussians and moments: what a texture of every browser holds."""


def browser_model(
    scene: Scene, camera: Camera, frames_per_second: float, *, unobserved: bool = False
) -> BrowserModel:
    """All of its time, as `camera` sees it first; one of the clip's moves as the clip's does. Raises
    UserError: a splat file per moment."""
    scene.require_same_tissue()
    frames = len(scene.cameras)
    moves = camera in scene.cameras and any(one != camera for one in scene.cameras)
    tolerance = TOLERANCE * scene.distance / scene.cameras[0].fx
    return extended(
        BrowserModel,
        scene.record,
        title=scene.title,
        camera=camera,
        moves=moves,
        zooms=moves and any(one.lens != camera.lens for one in scene.cameras),
        near=scene.near,
        unobserved=unobserved,
        ends="even",
        tolerance=tolerance,
        rounding=ROUNDING * tolerance,
        clip_frames=frames,
        start=scene.first,
        seconds=frames / frames_per_second,
    )


def far_off(record: BrowserModel, unit: str) -> str:
    """How far positions are from those of the model, in words; empty: within the tolerance."""
    if record.error is None or record.tolerance is None or record.error <= record.tolerance:
        return ""
    return f"shown with an error of up to {record.error:.2g} {unit}"


def page_windows(scene: Scene, tolerance: float | None, rounding: float | None) -> tuple[PageWindow, ...]:
    """Of its model, in the order of time; `tolerance` and `rounding`: see BrowserModel."""
    frames, most = len(scene.cameras), MOST_VALUES // max(len(scene.model), 1)
    nearness = None if tolerance is None else tolerance - (rounding or 0.0)

    def window(one: ModelWindow, there: range) -> PageWindow:
        sampling = None if nearness is None else Sampling(len(there), nearness, most)
        return PageWindow(tracks_of(one.model, sampling, rounding), there[0], there[-1], one.shown)

    return tuple(window(one, one.frames(frames)) for one in windows_of(scene.model))
