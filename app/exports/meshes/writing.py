"""Writes the file of a SurfaceMesh record, in the format of its suffix."""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path
from typing import Final

from app.errors import UserError
from app.exports.meshes.film import filmed
from app.exports.meshes.glb import glb_bytes
from app.exports.meshes.mesh_text import MOMENTS
from app.exports.meshes.usd import write_usd
from app.exports.records import SurfaceMesh
from app.exports.usd_file import require_usd
from app.files.atomic import write_bytes
from app.scenes.scene import Scene
from app.scenes.surfaces import moment_of_surface
from renderer.surface.fineness import Fineness

CLIPS: Final = (".glb", ".usdc")
"""Files that hold the whole clip."""


def write_surface(record: SurfaceMesh, scene: Scene, target: Path) -> Generator[int, None, None]:
    """One moment where the record has one, else all of the clip.

    Yields how many of its frames have been looked at. Raises UserError: no surface, or no such format.
    """
    suffix = target.suffix.lower()
    if suffix == ".usdc":
        # Before minutes of work for nothing.
        require_usd()
    fineness = Fineness(record.vertices, record.faces)
    if record.time is None and suffix in CLIPS:
        films = yield from filmed(scene, fineness)
        if suffix == ".usdc":
            write_usd(target, films, scene, record)
            return
        content = glb_bytes(films, scene, record)
    elif record.time is not None and suffix in MOMENTS:
        mesh = moment_of_surface(scene, record.time, fineness)
        content = MOMENTS[suffix](mesh, scene.unit, record.signed)
    else:
        raise UserError(
            f"expected one moment as {', '.join(MOMENTS)}, or a clip as {', '.join(CLIPS)}, got {target.name}"
        )
    write_bytes(target, content)
