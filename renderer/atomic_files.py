"""Files that appear whole or not at all, and stay so when the power goes."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final, ParamSpec

from renderer.leftovers import clear, sync_folder, temporary_name

Given = ParamSpec("Given")
PATIENCE: Final = 2.0
"""Seconds for which another program, such as a virus scanner, may hold a file."""


@contextmanager
def written_atomically(path: Path) -> Iterator[Path]:
    """An empty file beside `path`; once it is written, `path` holds all of it, and its old content till then.

    It is of this thread: another that writes the same file has its own. What killed processes have left
    beside it goes. A link at `path` is followed.

    Raises:
        OSError: it cannot be written; `path` is named, not the file beside it.
    """
    target = followed(path)
    clear(target.parent)
    partial = target.with_name(temporary_name(target.name))
    try:
        # A link that somebody has laid under this name is not followed.
        partial.unlink(missing_ok=True)
        partial.open("xb").close()
        yield partial
        # Windows syncs no file that is open for reading alone.
        with partial.open("rb+") as file:
            os.fsync(file.fileno())
        rename(partial, target)
    except OSError as error:
        if error.filename in (None, str(partial)):
            error.filename = str(path)
        raise
    finally:
        with suppress(OSError):  # As of a disk that is read-only, which is told already.
            partial.unlink()


def followed(path: Path) -> Path:
    """Where the link at `path` leads, else `path`: what is renamed onto a link takes its place."""
    return Path(os.path.realpath(path)) if path.is_symlink() else path


def unlinked(path: Path) -> Path:
    """`path` without the link there, whose target stays: for files of runs, which may be a stranger's."""
    if path.is_symlink():
        path.unlink()
    return path


def rename(partial: Path, path: Path) -> None:
    """Put a synced file into its place, for good."""
    patiently(partial.replace, path)
    sync_folder(path.parent)


def patiently(act: Callable[Given, object], *given: Given.args, **named: Given.kwargs) -> None:
    """Rename or remove by `act`. Windows refuses that while anybody has the file, or one in the folder, open:
    there it is tried again for a while.

    Raises OSError as `act` does.
    """
    until = time.monotonic() + (PATIENCE if sys.platform == "win32" else 0.0)
    while True:
        try:
            act(*given, **named)
            return
        except PermissionError:
            if time.monotonic() >= until:
                raise
            time.sleep(0.05)
