"""Small images of what was opened lately, for the first page: made once, then kept in the cache folder."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Final, Literal

import cv2

from app.errors import UserError
from app.files.atomic import write_bytes
from app.gui.session_file import SUFFIX, readable_session
from app.gui.work.opening import VIEW_SUFFIXES
from app.gui.work.thumbnails import shrunk
from app.runs.run_folder import RunFolder
from app.sweeps.folder import is_sweep
from renderer.clip import ByteImage, Clip, ClipError
from renderer.readers.clip_options import DEFAULTS
from renderer.readers.image_files.pictures import read_rgb
from renderer.sources import open_case
from renderer.splat_files import is_named_as_splats
from renderer.splat_series import series_files

SIDE: Final = 320
"""Pixels of the longer side."""
QUALITY: Final = 88
Kind = Literal["clip", "run", "splats", "report"]
PICTURED: Final = ("clip", "run")
TROUBLE: Final = (OSError, UserError, ClipError, ValueError, cv2.error)


@dataclass(frozen=True)
class RecentsRequest:
    """Of these paths, newest first; images of others go from the folder."""

    paths: tuple[str, ...]
    folder: Path


@dataclass(frozen=True, eq=False)
class Recent:
    """One of them: what it is by its name, whether it is still there, and how it looks."""

    kind: Kind
    missing: bool = False
    image: ByteImage | None = None
    """None while it is made, and where there is none."""


def find_recents(request: RecentsRequest) -> Iterator[Mapping[str, Recent]]:
    """By their paths: first which of them are there, then one image after the other."""
    keys = {text: _key(Path(text)) for text in request.paths}
    found = {text: Recent(_kind(Path(text)), key is None) for text, key in keys.items()}
    yield dict(found)
    names = set()
    for text, recent in found.items():
        key = keys[text]
        if key is None or recent.kind not in PICTURED:
            continue
        kept = request.folder / key
        names.add(key)
        image = _kept(kept)
        if image is None:
            image = _made(Path(text))
            _keep(kept, image)
        found[text] = replace(recent, image=image)
        yield dict(found)
    _forget(request.folder, names)


def _kind(path: Path) -> Kind:
    with suppress(OSError):  # The system may not let us look.
        if is_named_as_splats(path):
            return "splats"
        if path.suffix.lower() in VIEW_SUFFIXES or is_sweep(path):
            return "report"
        if RunFolder(path).is_run:
            return "run"
        if series_files(path):
            return "splats"
    return "clip"


def _key(path: Path) -> str | None:
    """The name of its image: another one once it has changed; None where nothing is there."""
    try:
        found = path.stat()
    except OSError:
        return None
    told = f"{path}\n{found.st_mtime_ns}\n{found.st_size}"
    return f"{sha256(told.encode(errors='replace')).hexdigest()[:32]}.jpg"


def _made(path: Path) -> ByteImage | None:
    """A frame of a clip, of the clip of a run, of the source of a session."""
    try:
        if path.suffix == SUFFIX:
            session = readable_session(path)
            source = session.source.found(path) if session and session.source else None
            return None if source is None or source.suffix == SUFFIX else _made(source)
        run, options = RunFolder(path), DEFAULTS
        if run.is_run:
            record = run.record()
            path, options = Path(record.clip.path), record.clip.options
        clip = open_case(path, options)
        return shrunk(_readable(clip), SIDE, SIDE, clip.pixel_aspect)
    except TROUBLE:
        return None


def _readable(clip: Clip) -> ByteImage:
    """The frame in the middle; the first where that one is damaged. Raises ClipError: neither can be read."""
    with suppress(ClipError):
        return clip.read_image(len(clip) // 2)
    return clip.read_image(0)


def _kept(file: Path) -> ByteImage | None:
    """None where there is none, or not what was kept."""
    with suppress(*TROUBLE):
        image = read_rgb(file)
        if max(image.shape[:2]) <= SIDE:
            return image
    return None


def _keep(file: Path, image: ByteImage | None) -> None:
    """Where nothing can be written, it is made the next time, too."""
    if image is None:
        return
    with suppress(*TROUBLE):
        _, content = cv2.imencode(".jpg", image[..., ::-1], (cv2.IMWRITE_JPEG_QUALITY, QUALITY))
        write_bytes(file, content.tobytes())


def _forget(folder: Path, names: set[str]) -> None:
    """Images of what is not in the list any more."""
    with suppress(OSError):
        for file in folder.glob("*.jpg"):
            if file.name not in names:
                file.unlink(missing_ok=True)
