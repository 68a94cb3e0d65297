"""What a page shows of a scene."""

from __future__ import annotations

from app.exports.records import BrowserModel
from app.files.records import extended
from app.scenes.scene import Scene
from renderer.camera import Camera


def browser_model(scene: Scene, camera: Camera, frames_per_second: float) -> BrowserModel:
    """All of its time, as `camera` sees it first. Raises UserError: its Gaussians change over time."""
    scene.require_one_model()
    frames = len(scene.cameras)
    return extended(
        BrowserModel,
        scene.record,
        title=scene.title,
        camera=camera,
        near=scene.near,
        clip_frames=frames,
        seconds=frames / frames_per_second,
    )
