"""The files of a clip by the number in their names, so that frames pair by number and never by sort order."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from pathlib import Path

from renderer.clip import ClipError
from renderer.listing import listed
from renderer.readers.image_files.file_kinds import is_picture

Accepts = Callable[[Path], bool]


def numbered(folder: Path, accepts: Accepts = is_picture) -> dict[int, Path]:
    """The accepted files of a folder by the last number of their stem, in its order.

    Raises:
        ClipError: no such folder, no such file in it, or two of one number.
    """
    if not folder.is_dir():
        raise ClipError(f"expected a folder {folder.name}/, got none: {folder}")
    found: dict[int, Path] = {}
    for entry in sorted(folder.iterdir()):
        number = number_of(entry) if accepts(entry) else None
        if number in found:
            both = f"{found[number].name} and {entry.name}"
            raise ClipError(f"expected one file per frame, got {both}, both number {number}: {folder}")
        if number is not None:
            found[number] = entry
    if not found:
        raise ClipError(f"expected files with numbers in their names, got none: {folder}")
    return dict(sorted(found.items()))


def beside(frames: Iterable[int], folder: Path, accepts: Accepts = is_picture) -> tuple[Path, ...]:
    """The accepted file in `folder` for each of the numbers `frames`, in that order.

    Raises:
        ClipError: as `numbered`, or a frame without a file.
    """
    found, wanted = numbered(folder, accepts), list(frames)
    missing = [str(number) for number in wanted if number not in found]
    if missing:
        lacking = f"none for {len(missing)} of {len(wanted)}, number {listed(missing)}"
        raise ClipError(f"expected a file for every frame, got {lacking}: {folder}")
    return tuple(found[number] for number in wanted)


def strays(frames: Iterable[int], folder: Path, accepts: Accepts = is_picture) -> list[str]:
    """A sentence about the visible files in `folder` that belong to none of `frames`, if there are any."""
    known = set(frames)
    visible = [entry for entry in sorted(folder.iterdir()) if not entry.name.startswith(".")]
    loose = [entry.name for entry in visible if not (accepts(entry) and number_of(entry) in known)]
    return [f"{folder.name}/ holds files that belong to no frame: {listed(loose)}"] if loose else []


def number_of(entry: Path) -> int | None:
    """The last number of a name without its suffix."""
    digits = re.findall(r"\d+", entry.stem)
    return int(digits[-1]) if digits else None
