"""A scene at one moment as a splat file, which records how it is rendered and what it is of."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from app.errors import UserError
from app.exports.records import Splats
from app.files.atomic import write_bytes
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


def write_splats(path: Path, scene: Scene, record: Splats) -> None:
    """A PLY file of the Gaussians where they are at the time of the record, which it holds. Raises UserError
    for a degree that would lose colours."""
    try:
        scene = of_degree(scene, record.sh_degree)
    except ValueError as error:
        got = f"{record.sh_degree} for {error}"
        raise UserError(f"expected a degree that holds the whole model, got {got}") from error
    raw = scene.model.motion.moved(scene.model.raw, record.time)
    write_bytes(path, ply_bytes(raw, scene.mode, comments(record.signed_without_hour)))
