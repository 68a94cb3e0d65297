"""A clip where it lies, or its bytes where it does not: for workers that share no folder with who asks."""

from __future__ import annotations

import io
import shutil
import tempfile
import zipfile
from functools import cache, lru_cache
from pathlib import Path
from typing import Final

from app.errors import UserError
from app.files.provenance import digest, digested_files
from renderer.atomic_files import patiently

MOST_BYTES: Final = 2_000_000_000
"""Of a clip that is sent; larger ones are for shared folders."""


class Missing(Exception):
    """Neither the clip nor its bytes are here."""


def located(path: Path, sha256: str, content: bytes | None) -> Path:
    """The clip at `path` if it is that clip, else a copy made of its content, kept while this process lasts.

    Raises:
        Missing: there is neither.
        UserError: the content is of another clip.
    """
    if _is_there(path, sha256):
        return path
    copy = Path(_copies().name, sha256)
    if copy.is_dir():
        return next(copy.iterdir())
    if content is None:
        raise Missing
    return _unpacked(content, sha256, copy)


@lru_cache(maxsize=1)
def packed(path: Path) -> bytes:
    """The files of a clip that its digest is of; packed once for all of its jobs.

    Raises:
        UserError: it is too large to be sent, or files of it lie beside its folder.
    """
    files = digested_files(path)
    size = sum(file.stat().st_size for file in files)
    if size > MOST_BYTES:
        raise UserError(
            f"expected at most {MOST_BYTES / 1e9:.0f} GB to send, got {size / 1e9:.1f} GB: put it into a "
            f"folder that workers see: {path.name}"
        )
    memory = io.BytesIO()
    # Archives know no time before 1980, which devices without a clock give their files.
    with zipfile.ZipFile(memory, "w", strict_timestamps=False) as archive:
        for file in files:
            inside = file.name if file == path else _inside(file, path)
            archive.write(file, f"{path.name}/{inside}" if path.is_dir() else inside)
    return memory.getvalue()


def _inside(file: Path, folder: Path) -> str:
    if not file.is_relative_to(folder):
        raise UserError(
            f"expected all files of the clip in its folder, to send it, got one beside it: {file.name}"
        )
    return file.relative_to(folder).as_posix()


def _unpacked(content: bytes, sha256: str, copy: Path) -> Path:
    staging = copy.with_name(f"{sha256}-unfinished")
    shutil.rmtree(staging, ignore_errors=True)
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        archive.extractall(staging)
    if digest(next(staging.iterdir())) != sha256:
        raise UserError("expected the content of the clip, got another's")
    patiently(staging.rename, copy)
    return next(copy.iterdir())


@cache
def _copies() -> tempfile.TemporaryDirectory[str]:
    """Deleted when the process ends: clips are of patients."""
    return tempfile.TemporaryDirectory(prefix="vesselsplat-clips-")


def _is_there(path: Path, sha256: str) -> bool:
    try:
        return _digest(path, _state(path)) == sha256
    except OSError:
        return False


@lru_cache(maxsize=256)
def _digest(path: Path, state: int) -> str:
    """Once a clip and process, and again for another `state` of its files."""
    return digest(path)


def _state(path: Path) -> int:
    """Of all files of a clip, by a look at their sizes and times: a folder's own time says nothing of a file
    that is overwritten in it. Raises OSError: one is not there."""
    stats = ((file, file.stat()) for file in digested_files(path))
    return hash(tuple((file, found.st_size, found.st_mtime_ns) for file, found in stats))
