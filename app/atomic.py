"""Outputs that appear whole or not at all: written beside their place, then renamed into it."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from app.errors import UserError


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
        yield temporary
        with temporary.open("rb") as file:
            os.fsync(file.fileno())
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def write_bytes(path: Path, content: bytes) -> None:
    """The file at `path` becomes `content`, or stays as it was."""
    with replaced(path) as temporary:
        temporary.write_bytes(content)


@contextmanager
def filled(folder: Path) -> Iterator[Path]:
    """A temporary folder; its files move into `folder` when the block ends well, else they vanish."""
    if folder.exists() and not folder.is_dir():
        raise UserError(f"expected a folder to write into, got a file: {folder}")
    ancestor = next(parent for parent in folder.absolute().parents if parent.is_dir())
    staging = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", suffix=".partial", dir=ancestor))
    try:
        yield staging
        make_folder(folder)
        for item in sorted(staging.iterdir()):
            os.replace(item, folder / item.name)
    finally:
        shutil.rmtree(staging, ignore_errors=True)


def make_folder(folder: Path) -> None:
    """Make a folder and its parents. Raises UserError when a file is in the way."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError) as error:
        raise UserError(f"expected a folder, got a file on the way to {folder}") from error
