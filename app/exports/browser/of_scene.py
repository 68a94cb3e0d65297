"""What a page shows of a scene."""

from __future__ import annotations

from app.exports.browser.page import PageWindow
from app.exports.browser.tracks import tracks_of
from app.exports.records import BrowserModel
from app.files.records import extended
from app.scenes.scene import Scene
from renderer.camera import Camera
from renderer.model_windows import windows_of


def browser_model(scene: Scene, camera: Camera, frames_per_second: float) -> BrowserModel:
    """All of its time, as `camera` sees it first; one of the clip's moves as the clip's does. Raises
    UserError: a splat file per moment."""
    scene.require_same_tissue()
    frames = len(scene.cameras)
    return extended(
        BrowserModel,
        scene.record,
        title=scene.title,
        camera=camera,
        moves=camera in scene.cameras and any(one != camera for one in scene.cameras),
        near=scene.near,
        clip_frames=frames,
        start=scene.first,
        seconds=frames / frames_per_second,
    )


def page_windows(scene: Scene) -> tuple[PageWindow, ...]:
    """Of its model, in the order of time."""
    frames = len(scene.cameras)
    parts = ((tracks_of(one.model), one.frames(frames)) for one in windows_of(scene.model))
    return tuple(PageWindow(tracks, there[0], there[-1]) for tracks, there in parts)
