"""Outputs that appear whole or not at all: written beside their place, then renamed into it."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from app.errors import UserError
from renderer.atomic_files import rename, sync_folder


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """A temporary path beside `path`; what is written there takes its place when the block ends well.

    The suffix is kept, since writers choose their format by it. Parents of `path` are made.

    Raises:
        UserError: `path` is a folder, or its parent is a file.
    """
    if path.is_dir():
        raise UserError(f"expected the path of a file to write, got a folder: {path}")
    make_folder(path.parent)
    temporary = path.with_name(f".{path.stem}-{os.getpid()}.partial{path.suffix}")
    try:
        with _told_as(path, temporary):
            # A link that somebody has laid under this name is not followed.
            temporary.unlink(missing_ok=True)
            yield temporary
            # Windows syncs no file that is open for reading alone.
            with temporary.open("rb+") as file:
                os.fsync(file.fileno())
            rename(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def write_bytes(path: Path, content: bytes) -> None:
    """The file at `path` becomes `content`, or stays as it was."""
    with replaced(path) as temporary:
        temporary.write_bytes(content)


@contextmanager
def filled(folder: Path) -> Iterator[Path]:
    """A temporary folder; its files move into `folder` when the block ends well, else they vanish.

    It lies in `folder` where that exists, else in the nearest folder above, so on the same file system.

    Raises:
        UserError: `folder` is a file or cannot be written, or a folder is where one of the files belongs.
    """
    if folder.exists() and not folder.is_dir():
        raise UserError(f"expected a folder to write into, got a file: {folder}")
    target = folder.absolute()
    nearest = next(place for place in (target, *target.parents) if place.is_dir())
    try:
        staging = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", suffix=".partial", dir=nearest))
    except OSError as error:
        raise UserError(f"cannot write into the folder, {error.strerror}: {folder}") from error
    try:
        with _told_as(folder, staging):
            yield staging
        make_folder(folder)
        names = sorted(item.name for item in staging.iterdir())
        for name in names:
            if (folder / name).is_dir():
                raise UserError(f"expected the place of a file to write, got a folder: {folder / name}")
        for name in names:
            os.replace(staging / name, folder / name)
        sync_folder(folder)
    finally:
        shutil.rmtree(staging, ignore_errors=True)


@contextmanager
def _told_as(place: Path, temporary: Path) -> Iterator[None]:
    """Errors that name the temporary path, or a file in it, name what it stands for."""
    try:
        yield
    except OSError as error:
        if isinstance(error.filename, str) and (named := Path(error.filename)).is_relative_to(temporary):
            error.filename = str(place / named.relative_to(temporary))
        raise


def make_folder(folder: Path) -> None:
    """Make a folder and its parents. Raises UserError when a file is in the way."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError) as error:
        raise UserError(f"expected a folder, got a file on the way to {folder}") from error
