"""A scene at one moment as a splat file, which records how it is rendered and what it is of."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from app.files.provenance import comments
from app.scenes.scene import Scene
from renderer.splat_files.inria_ply import ply_bytes


def of_degree(scene: Scene, degree: int | None) -> Scene:
    """Its spherical harmonics filled up with zeros to `degree`, 0 to 3; None: as they are.

    Raises:
        ValueError: it would lose colours.
    """
    if degree is None:
        return scene
    raw = scene.model.raw.of_degree(degree)
    return replace(scene, model=replace(scene.model, raw=raw))


def splat_file(scene: Scene, time: float, facts: dict[str, Any]) -> bytes:
    """The content of a PLY file of the Gaussians where they are at `time` in [0, 1], with its provenance."""
    return ply_bytes(scene.model.motion.moved(scene.model.raw, time), scene.mode, comments(facts))
