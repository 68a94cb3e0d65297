"""The files that a clip is read from, as each reader tells them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from renderer.readers.image_files.file_kinds import is_picture, is_visible, natural_key
from renderer.readers.numbered_files import number_of


@dataclass(frozen=True)
class ClipFiles:
    """What a reader takes from its folder, but for right pictures and monocular maps, which any layout
    may have."""

    frames: tuple[Path, ...]
    """In the order of the frames; further ones that belong to no frame may be among them."""
    others: tuple[Path, ...] = ()
    """Depth, masks, poses, calibration: those too that are read under some option alone, or in place of
    others that are missing."""


def files_in(folder: Path) -> Iterator[Path]:
    """The files of a folder but for hidden ones and links that lead nowhere; none without a folder."""
    for entry in folder.iterdir() if folder.is_dir() else ():
        if entry.is_file() and not entry.name.startswith("."):
            yield entry


def folders_in(folder: Path) -> list[Path]:
    """The visible folders in a folder, sorted; none without a folder."""
    inside = sorted(folder.iterdir()) if folder.is_dir() else ()
    return [entry for entry in inside if is_visible(entry) and entry.is_dir()]


def numbered_pictures(folder: Path) -> tuple[Path, ...]:
    """The pictures of a folder with a number in their names, else all, in natural order: beside a numbered
    picture, readers leave the others out."""
    pictures = sorted(filter(is_picture, files_in(folder)), key=natural_key)
    return tuple(path for path in pictures if number_of(path) is not None) or tuple(pictures)


def pictures_of(folder: Path, names: Iterable[str]) -> tuple[Path, ...]:
    """`numbered_pictures` of the folders of these names in a folder."""
    return tuple(path for name in names for path in numbered_pictures(folder / name))


def those_there(folder: Path, names: Iterable[str]) -> tuple[Path, ...]:
    """The files of these names in a folder, those that are there."""
    return tuple(path for name in names if (path := folder / name).is_file())
