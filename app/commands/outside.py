"""Refuses outputs that would lie in the run or the clip that they are made from, or over its splat files."""

from __future__ import annotations

from pathlib import Path

from app.errors import UserError
from app.scenes.scene import Scene


def require_outside(flag: str, out: Path, scene: Scene) -> None:
    """Raises UserError: what `flag` writes to `out` would lie in the folder of the scene's run, of its clip
    or of its splat files, whose readers would find it there."""
    own = "run" if scene.record.splats is None else "splat files"
    for path, what in ((scene.path, own), (scene.clip_path, "clip of the run")):
        if path is not None and path.is_dir() and out.resolve().is_relative_to(path.resolve()):
            raise UserError(f"{flag}: expected a place outside the {what} {path}, got {out}")


def require_no_overwriting(flag: str, out: Path, scene: Scene) -> None:
    """Raises UserError: `out` is the scene's splat file, or the folder of that file, where numbered splat
    files would be written over it or over others of its series."""
    if scene.path is not None and scene.path.is_file():
        own = scene.path.resolve()
        if out.resolve() in (own, own.parent):
            raise UserError(f"{flag}: expected a place apart from the splat file {scene.path}, got {out}")
