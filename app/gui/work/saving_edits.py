"""Keeps edits on disk, beside their run or as another file of splats: off the window's thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from app.exports.make import make
from app.exports.records import Splats
from app.exports.sources import Opened
from app.files.records import extended
from app.files.stepping import run_to_end
from app.runs.run_edits import save_edits, saved_since
from app.runs.run_folder import RunFolder
from app.scenes.scene import Scene
from renderer.editing.edits import Edits


@dataclass(frozen=True, eq=False)
class SaveRequest:
    """One wish to save; a second wish for the same is another request."""

    base: Scene
    """Without any edit."""
    path: Path
    """Its run folder or file of splats."""
    edits: Edits
    known: Edits
    """What the window believes to be on disk."""
    time: float
    """In [0, 1]; of a file of splats, the moment that is written."""


@dataclass(frozen=True, eq=False)
class SavedEdits:
    """What has been done."""

    path: Path
    """A run folder, or the file that was written."""
    replaced_by: Edits | None = None
    """What another window has saved meanwhile: then nothing was written."""


def keep_edits(request: SaveRequest) -> Iterator[SavedEdits]:
    """Answers a SaveRequest. Raises OSError or UserError."""
    if not request.base.is_of_run:
        yield SavedEdits(write_splats(request))
        return
    folder = RunFolder(request.path)
    other = saved_since(folder, request.known)
    if other is None:
        save_edits(folder, request.edits)
    yield SavedEdits(request.path, other)


def write_splats(request: SaveRequest) -> Path:
    """What can be seen at the present time, beside its source; never over another file."""
    source = request.path
    stem = source.name.removesuffix(source.suffix).removesuffix(".compressed")
    path, number = source.with_name(f"{stem}-edited.ply"), 2
    while path.exists():
        path, number = source.with_name(f"{stem}-edited-{number}.ply"), number + 1
    scene = request.base.edited(request.edits)
    record = extended(Splats, scene.record, time=request.time)
    run_to_end(make(record, Opened(model=scene), path))
    return path
