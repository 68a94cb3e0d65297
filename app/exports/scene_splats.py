"""A scene at one moment as a splat file, which records how it is rendered and what it is of."""

from __future__ import annotations

from pathlib import Path

from app.errors import UserError
from app.exports.records import Splats
from app.files.atomic import write_bytes
from app.files.provenance import comments
from app.scenes.scene import Scene
from renderer.splat_files.inria_ply import ply_bytes


def write_splats(path: Path, scene: Scene, record: Splats) -> None:
    """A PLY file of the Gaussians where they are at the time of the record, which it holds; their spherical
    harmonics are filled up with zeros to its degree. Raises UserError for one that would lose colours."""
    raw, degree = scene.model.raw, record.sh_degree
    try:
        raw = raw if degree is None else raw.of_degree(degree)
    except ValueError as error:
        got = f"{degree} for {error}"
        raise UserError(f"--sh-degree: expected one that holds the whole model, got {got}") from error
    moved = scene.model.motion.moved(raw, record.time)
    write_bytes(path, ply_bytes(moved, scene.mode, comments(record.signed)))
