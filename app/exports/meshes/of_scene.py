"""The record of a surface file, from a scene."""

from __future__ import annotations

from app.exports.records import SurfaceMesh
from app.files.records import extended
from app.scenes.scene import Scene
from renderer.surface.fineness import VERTICES


def surface_mesh(
    scene: Scene,
    frames_per_second: float,
    frame: int | None = None,
    time: float | None = None,
    *,
    vertices: int = VERTICES,
    faces: int | None = None,
) -> SurfaceMesh:
    """At `time` in [0, 1], or through the clip, of a model in windows as one mesh of each. Raises UserError:
    a splat file per moment."""
    scene.require_same_tissue()
    return extended(
        SurfaceMesh,
        scene.record,
        title=scene.title,
        time=time,
        frame=frame,
        seconds=len(scene.cameras) / frames_per_second,
        vertices=vertices,
        faces=faces,
    )
