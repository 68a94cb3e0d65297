"""What a folder holds, for the file dialog, and its files in small: off the window's thread."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal

import cv2
import numpy as np
from PIL import Image, ImageOps

from app.errors import UserError
from app.files.legible import legible
from renderer.budget import OverBudget
from renderer.clip import ByteImage, ClipError
from renderer.pyav_presence import has_pyav
from renderer.readers.dicom.header import holds_stream
from renderer.readers.image_files.coded_picture import CODED
from renderer.readers.image_files.file_kinds import VIDEOS, is_picture, is_visible, moves, natural_key
from renderer.readers.image_files.picture_files import BROKEN, opened
from renderer.readers.image_files.pictures import read_rgb
from renderer.readers.image_files.used_bits import holds_deep, used_bits
from renderer.readers.image_folders.picture_kinds import kind_by_name
from renderer.utf8_paths import not_utf8

if TYPE_CHECKING:
    from av.container import InputContainer

MOVING: Final = VIDEOS | {".gif", ".ts"}
"""Endings of videos, and of what may be one."""
SIDE: Final = 160
"""Pixels of the longer side of a thumbnail."""
LOOKED_AT: Final = 500
"""Files of a folder among which the one is looked for that stands for it."""


@dataclass(frozen=True)
class ListRequest:
    """A folder to look into."""

    folder: Path
    is_made: bool = False
    """It is made with the file that is written into it: until then it may be missing, and is empty."""


@dataclass(frozen=True)
class Entry:
    """What lies in it."""

    path: Path
    kind: Literal["folder", "file"] | None
    """None: neither, or the system does not let us look at it."""
    modified: float = 0.0
    """Seconds since 1970."""
    size: int = 0
    """Bytes of a file."""

    @property
    def name(self) -> str:
        return legible(self.path.name)

    @property
    def may_have_thumbnail(self) -> bool:
        return self.kind == "folder" or self.path.suffix.lower() in MOVING | CODED or is_picture(self.path)


@dataclass(frozen=True, eq=False)
class Listing:
    """Neither hidden files nor hidden folders."""

    folder: Path
    """The one asked for, or where that is gone the nearest that is there."""
    entries: tuple[Entry, ...] = ()
    trouble: str = ""
    """Why it cannot be looked into."""

    @cached_property
    def videos(self) -> int:
        """How many of the files are videos by their names."""
        return sum(entry.kind == "file" and entry.path.suffix.lower() in VIDEOS for entry in self.entries)


def list_folder(request: ListRequest) -> Iterator[Listing]:
    """Answers a ListRequest."""
    if request.is_made and not request.folder.exists():
        yield Listing(request.folder)
        return
    folder = nearest(request.folder)
    if folder is None:
        raise UserError(f"the folder cannot be found: {request.folder}")
    try:
        with os.scandir(folder) as items:
            paths = [Path(item.path) for item in items if not item.name.startswith(".")]
    except OSError as error:
        yield Listing(folder, trouble=f"The folder cannot be read: {error.strerror}.")
        return
    yield Listing(folder, tuple(map(entry_at, sorted(paths))))


def nearest(folder: Path) -> Path | None:
    """The folder, or where that is gone the nearest above it that is there."""
    return next((one for one in (folder, *folder.parents) if is_folder(one)), None)


def is_folder(path: Path) -> bool:
    """False also where the system does not let us look."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def entry_at(path: Path) -> Entry:
    """What lies there."""
    try:
        found = path.stat()
    except (OSError, ValueError):
        return Entry(path, None)
    if stat.S_ISDIR(found.st_mode):
        return Entry(path, "folder", found.st_mtime)
    return Entry(path, "file" if stat.S_ISREG(found.st_mode) else None, found.st_mtime, found.st_size)


def thumbnail_of(path: Path) -> Iterator[ByteImage | None]:
    """The file in small, (h, w, 3), or of a folder its first image; None where there is nothing to see."""
    try:
        yield _small(path)
    except (UserError, ClipError, OverBudget, *BROKEN, cv2.error):
        yield None


def _small(path: Path) -> ByteImage | None:
    if path.is_dir():
        first = _first_image(path)
        return None if first is None else _small(first)
    if moves(path):
        frame = _video_frame(path)
        return None if frame is None else _shrunk(Image.fromarray(frame))
    if holds_deep(path):
        return _shrunk(Image.fromarray(read_rgb(path, used_bits((path,)))))
    with opened(path) as picture:
        if not picture.mode.startswith(("I", "F")):
            picture.draft("RGB", (SIDE, SIDE))
            return _shrunk(ImageOps.exif_transpose(picture).convert("RGB"))
    return _shrunk(Image.fromarray(read_rgb(path)))


def _shrunk(picture: Image.Image) -> ByteImage:
    picture.thumbnail((SIDE, SIDE))
    return np.array(picture, np.uint8)


def _first_image(folder: Path) -> Path | None:
    """Of the folder, or of the first one in it that holds frames: neither a mask nor a map by its name."""
    paths, folders = _inside(folder)
    found = min(paths, key=natural_key, default=None)
    inside = (min(_inside(one)[0], key=natural_key, default=None) for one in sorted(folders))
    return found or next(filter(None, inside), None)


def _inside(folder: Path) -> tuple[list[Path], list[Path]]:
    """Images and folders."""
    try:
        with os.scandir(folder) as items:
            found = [(Path(item.path), item.is_dir()) for item in islice(items, LOOKED_AT)]
    except OSError:
        return [], []
    shown = [(path, is_dir) for path, is_dir in found if kind_by_name(path.stem) is None and is_visible(path)]
    images = [
        path for path, is_dir in shown if not is_dir and (is_picture(path) or path.suffix.lower() in CODED)
    ]
    return images, [path for path, is_dir in shown if is_dir]


def _video_frame(path: Path) -> ByteImage | None:
    """One at a tenth of the whole, as the first ones are often black."""
    if not_utf8(path):
        return None
    if not holds_stream(path):
        return read_rgb(path)
    if has_pyav():
        return _frame_by_pyav(path)
    capture = cv2.VideoCapture(str(path))
    try:
        capture.set(cv2.CAP_PROP_POS_FRAMES, int(capture.get(cv2.CAP_PROP_FRAME_COUNT)) // 10)
        there, frame = capture.read()
        return np.asarray(cv2.cvtColor(frame, cv2.COLOR_BGR2RGB), np.uint8) if there else None
    finally:
        capture.release()


def _frame_by_pyav(path: Path) -> ByteImage | None:
    import av

    from renderer.readers.video_decoding.video_index import open_container

    try:
        with open_container(path) as container:
            if container.duration:
                container.seek((container.start_time or 0) + container.duration // 10)
            found = _next_frame(container, path)
        if found is None:  # A transport stream has no list of places to go to.
            with open_container(path) as container:
                found = _next_frame(container, path)
        return found
    except av.error.FFmpegError:
        return None


def _next_frame(container: InputContainer, path: Path) -> ByteImage | None:
    """Upright, in the shape that it has on the screen."""
    from renderer.readers.video_decoding.video_index import decoded, video_stream
    from renderer.readers.video_decoding.video_shape import pixel_aspect, upright

    stream = video_stream(container, path)
    frame = next(decoded(container, stream), None)
    if frame is None:
        return None
    image = upright(frame, np.asarray(frame.to_ndarray(format="rgb24"), np.uint8))
    across = max(1, round(image.shape[1] * float(pixel_aspect(stream, frame))))
    return np.asarray(cv2.resize(np.ascontiguousarray(image), (across, image.shape[0])), np.uint8)
