"""No input is ever overwritten: where inputs lie, also by links, and which outputs would meet them there."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from app.errors import UserError
from renderer.layouts import layout_of
from renderer.readers.picture_kinds import frame_folder

Identity = tuple[int, int]
"""Of a file or folder on its disk, whatever name or letter case leads to it."""


def require_outside(output: Path, folders: Iterable[Path]) -> None:
    """Raises UserError: the output is one of the folders or lies in it, so that a second batch would take it
    for an input."""
    holding = identities((output.resolve(), *output.resolve().parents))
    for folder in folders:
        if not holding.isdisjoint(identities((folder,))):
            raise UserError(f"expected OUTPUT outside of the input folder {folder}, got {output}")


def require_other(outputs: Iterable[Path], inputs: set[Identity]) -> None:
    """Raises UserError: one of the outputs, a file or a folder to write into, is among the inputs."""
    for output in outputs:
        if not identities((output,)).isdisjoint(inputs):
            raise UserError(f"expected OUTPUT other than INPUT, which is never overwritten: {output}")


def identities(paths: Iterable[Path]) -> set[Identity]:
    """Of those that are there."""
    found = set[Identity]()
    for path in paths:
        with suppress(OSError):
            status = path.stat()
            found.add((status.st_dev, status.st_ino))
    return found


def homes(files: Iterable[Path]) -> set[Identity]:
    """Of the folders that hold the files: where they are named, and where links lead."""
    places = {place for path in files for place in (path.parent, path.resolve().parent)}
    return identities(places)


def files_of(source: Path) -> tuple[Path, ...]:
    """What is read of an image, a video, a folder of images or a clip; nothing where it cannot be."""
    if source.is_file():
        return (source,)
    with suppress(OSError):
        layout = layout_of(source)
        return layout.files(source) if layout.is_data_set else tuple(frame_folder(source).iterdir())
    return ()
