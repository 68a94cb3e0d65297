"""Outputs that appear complete or not at all: written beside their place, then renamed into it."""

from __future__ import annotations

import errno
import os
import secrets
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from app.errors import UserError
from renderer.atomic_files import followed, patiently, rename
from renderer.leftovers import clear, commit_name, put_into_place, sync_folder, temporary_name

NO_SPACE = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT)
"""Of a write, which names no file: the system tells neither."""
LONG = 248
"""Characters of a path with which Windows, as installed, makes no folder; a file may have eleven more."""


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """A temporary path beside `path`; what is written there takes its place when the block ends well.

    The suffix is kept, since writers choose their format by it. Parents of `path` are made; a link there is
    followed.

    Raises:
        UserError: `path` is a folder, or its parent is a file.
    """
    _require_file(path)
    make_folder(path.parent)
    target = followed(path)
    clear(target.parent)
    temporary = target.with_name(temporary_name(path.stem, path.suffix))
    try:
        with told_as(path, temporary):
            # A link that somebody has laid under this name is not followed.
            temporary.unlink(missing_ok=True)
            yield temporary
            _sync(temporary)
            rename(temporary, target)
    finally:
        with suppress(OSError):  # As of a disk that is read-only, which is told already.
            temporary.unlink()


def write_bytes(path: Path, content: bytes) -> None:
    """The file at `path` becomes `content`, or stays as it was."""
    with replaced(path) as temporary:
        temporary.write_bytes(content)


@contextmanager
def filled(folder: Path) -> Iterator[Path]:
    """A temporary folder; its files move into `folder` when the block ends well, else they vanish.

    It lies in `folder` where that exists, else in the nearest folder above, so on the same file system: what
    the files replace may be links, which are not followed.

    Raises:
        UserError: `folder` is a file or cannot be written, or a folder is where one of the files belongs.
    """
    if folder.exists() and not folder.is_dir():
        raise UserError(f"expected a folder to write into, got a file: {folder}")
    target = folder.absolute()
    nearest = next(place for place in (target, *target.parents) if place.is_dir())
    clear(nearest)
    staging = nearest / temporary_name(f"{folder.name}-{secrets.token_hex(4)}")
    try:
        staging.mkdir()
    except OSError as error:
        raise UserError(f"cannot write into the folder, {_reason(error)}: {folder}") from error
    try:
        with told_as(folder, staging):
            yield staging
            make_folder(folder)
            _commit(staging, folder)
    finally:
        shutil.rmtree(staging, ignore_errors=True)


def require_there(folder: Path) -> None:
    """Of work that goes on in a folder for long: an open file is written on where its folder is gone.

    Raises UserError: it was deleted or moved away, or its disk was unplugged.
    """
    if not folder.is_dir():
        raise UserError(f"expected the folder to stay while a file is written into it, got it gone: {folder}")


@contextmanager
def together(path: Path) -> Iterator[Path]:
    """The temporary place of a file, beside which more may be written: all appear at once.

    Raises:
        UserError: `path` is a folder, or its parent is a file.
    """
    _require_file(path)
    make_folder(path.parent)
    with filled(path.parent) as staging:
        yield staging / path.name


def _commit(staging: Path, folder: Path) -> None:
    """One rename decides: before it nothing has changed, after it the next process would go on."""
    for item in sorted(staging.iterdir()):
        _require_file(folder / item.name)
        _sync(item)
    sync_folder(staging)
    ready = folder / commit_name(staging.name)
    patiently(os.replace, staging, ready)
    sync_folder(folder)
    # It goes on where it was refused.
    patiently(put_into_place, ready)


def _require_file(path: Path) -> None:
    if path.is_dir():
        raise UserError(f"expected the path of a file to write, got a folder: {path}")


def _sync(file: Path) -> None:
    # Windows syncs no file that is open for reading alone.
    with file.open("rb+") as opened:
        os.fsync(opened.fileno())


@contextmanager
def told_as(place: Path, temporary: Path) -> Iterator[None]:
    """Errors that name the temporary path, or a file in it, name what it stands for."""
    try:
        yield
    except UserError as error:
        raise UserError(str(error).replace(str(temporary), str(place))) from error
    except OSError as error:
        # FFmpeg gets its paths as addresses.
        told = error.filename.removeprefix("file:") if isinstance(error.filename, str) else ""
        if told and (named := Path(told)).is_relative_to(temporary):
            stands_for = place / named.relative_to(temporary)
        elif error.errno in NO_SPACE and not error.filename:
            stands_for = place
        else:
            raise
        # An error of PyAV takes no other name.
        raise OSError(error.errno, _reason(error), str(stands_for)) from error


def _reason(error: OSError) -> str | None:
    """Temporary names are longer than those that they stand for; Windows finds no path that is too long."""
    too_long = sys.platform == "win32" and error.errno == errno.ENOENT and len(str(error.filename)) >= LONG
    return "the path is too long for Windows, take a shorter one" if too_long else error.strerror


def make_folder(folder: Path) -> None:
    """Make a folder and its parents. Raises UserError when a file is in the way."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError) as error:
        raise UserError(f"expected a folder, got a file as a parent of {folder}") from error


@contextmanager
def made(folder: Path) -> Iterator[None]:
    """The folder and its parents are made; one that is new and still empty at the end is gone again."""
    is_new = not folder.exists()
    make_folder(folder)
    try:
        yield
    finally:
        if is_new:
            with suppress(OSError):  # Something is in it.
                folder.rmdir()
