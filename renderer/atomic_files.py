"""Files that appear whole or not at all, and stay so when the power goes."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

PARTIAL: Final = ".partial"
"""Ends the name of a file that is being written."""


@contextmanager
def written_atomically(path: Path) -> Iterator[Path]:
    """An empty file beside `path`; once it is written, `path` holds all of it, and its old content till then.

    Raises:
        OSError: it cannot be written; `path` is named, not the file beside it.
    """
    partial = path.with_name(path.name + PARTIAL)
    try:
        # What lies there is a killed process's, or a link that somebody has laid: it is not followed.
        partial.unlink(missing_ok=True)
        partial.open("xb").close()
        yield partial
        # Windows syncs no file that is open for reading alone.
        with partial.open("rb+") as file:
            os.fsync(file.fileno())
        rename(partial, path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        if error.filename in (None, str(partial)):
            error.filename = str(path)
        raise
    except BaseException:
        partial.unlink(missing_ok=True)
        raise


def rename(partial: Path, path: Path) -> None:
    """Put a synced file into its place, for good."""
    partial.replace(path)
    sync_folder(path.parent)


def sync_folder(folder: Path) -> None:
    """What was renamed in it outlives a power cut; Windows has no such call, and needs none."""
    if os.name == "nt":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
