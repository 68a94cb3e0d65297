"""No input is ever overwritten, and no other file unasked: where inputs lie, also by links, and which outputs
would meet them there."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from app.errors import UserError
from app.files.image_files import frames_in
from app.files.provenance import is_ours
from renderer.clip import ClipError
from renderer.layouts import layout_of

Identity = tuple[int, int] | Path
"""Of a file or folder on its disk, whatever name or letter case leads to it; where the disk numbers no files,
its path without links."""


def require_outside(output: Path, folders: Iterable[Path]) -> None:
    """Raises UserError: the output is one of the folders or lies in it, so that a second batch would take it
    for an input."""
    holding = identities((output.resolve(), *output.resolve().parents))
    for folder in folders:
        if not holding.isdisjoint(identities((folder,))):
            raise UserError(f"expected an output outside of the input folder {folder}, got {output}")


def require_other(outputs: Iterable[Path], inputs: set[Identity]) -> None:
    """Raises UserError: one of the outputs, a file or a folder to write into, is among the inputs."""
    for output in outputs:
        if not identities((output,)).isdisjoint(inputs):
            raise UserError(f"expected OUTPUT other than INPUT, which is never overwritten: {output}")


def require_own(*outputs: Path) -> None:
    """Raises UserError: under a name that follows from that of an input, another program's file is there."""
    for output in outputs:
        if output.exists() and not is_ours(output):
            raise UserError(f"expected no file there, or one of VesselSplat's, which is replaced: {output}")


def identities(paths: Iterable[Path]) -> set[Identity]:
    """What the files at these paths are known by, whatever path leads to them; none for paths without one."""
    found = set[Identity]()
    for path in paths:
        with suppress(OSError):
            status = path.stat()
            found.add((status.st_dev, status.st_ino) if status.st_ino else path.resolve())
    return found


def homes(files: Iterable[Path]) -> set[Identity]:
    """Of the folders that hold the files: where they are named, and where links lead."""
    places = {place for path in files for place in (path.parent, path.resolve().parent)}
    return identities(places)


def files_of(source: Path) -> tuple[Path, ...]:
    """What is read of an image, a video, a folder of images or a clip, frames first; nothing where it cannot
    be."""
    if source.is_file():
        return (source,)
    with suppress(OSError, UserError, ClipError):
        layout = layout_of(source)
        return layout.files(source) if layout.is_data_set else frames_in(source).frames
    return ()
