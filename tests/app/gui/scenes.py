"""Scenes without files."""

from __future__ import annotations

from app.scenes.records import RunSource, SceneRecord
from app.scenes.scene import Scene
from renderer.camera import Camera
from renderer.gaussians import DynamicGaussians


def scene_of(
    model: DynamicGaussians, cameras: tuple[Camera, ...], name: str = "run", steps: int = 7
) -> Scene:
    """Of a finished run, 50 before its first camera."""
    return Scene(
        name=name,
        model=model,
        cameras=cameras,
        distance=50.0,
        mode="default",
        unit="scene units",
        record=SceneRecord(run=RunSource(name=name)),
        iteration=steps,
        iterations=steps,
    )
