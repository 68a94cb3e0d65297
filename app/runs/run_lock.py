"""Which process trains a run: a lock of the system, and a small hidden file that says who has it."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

import psutil
from filelock import FileLock, Timeout

from app.errors import UserError
from app.files.atomic import write_bytes
from renderer.atomic_files import patiently, unlinked
from renderer.json_files import read_json
from renderer.leftovers import lives, mark_of, written_as

NAME, LOCK = ".training.json", ".training.lock"
_WRITTEN: Final = re.compile(r"(checkpoint-\d+|model)\.safetensors")
"""What a training writes. Other programs end names of temporary files in the same way, and may have files in
its folder."""


@contextmanager
def locked(run: Path) -> Iterator[None]:
    """Nobody else trains the run meanwhile. Raises UserError when another process does.

    The system lets go of the lock when its process ends, however it ends.
    """
    file, process = run / NAME, os.getpid()
    lock = FileLock(run / LOCK, blocking=False, thread_local=False)
    try:
        lock.acquire()
    except Timeout as error:
        raise _held(run, holder(run)) from error
    try:
        # What killed processes were writing: nobody else writes here now.
        for partial in _partial_files(run):
            patiently(partial.unlink)
        write_bytes(unlinked(file), json.dumps({"process": process, "mark": mark_of(process)}).encode())
        yield
    finally:
        # Windows keeps it for a reader; what stays is as if the process had been killed.
        with suppress(PermissionError):
            patiently(file.unlink, missing_ok=True)
        # Removed while it is held, so that nobody else's is; Windows lets go of it first.
        with suppress(PermissionError):
            (run / LOCK).unlink(missing_ok=True)
        lock.release()


def require_free(run: Path) -> None:
    """Raises UserError: by its file, another process trains the run; `locked` alone makes sure of it."""
    if (other := holder(run)) not in (None, os.getpid()):
        raise _held(run, other)


def _held(run: Path, process: int | None) -> UserError:
    who = f", {process}" if process else ""
    return UserError(f"the run is being trained by another process{who}: {run}")


def _partial_files(run: Path) -> list[Path]:
    found = (path for path in run.iterdir() if _WRITTEN.fullmatch(written_as(path.name) or ""))
    return [path for path in found if path.is_symlink() or path.is_file()]


def clear_training(run: Path, *, is_run: bool) -> None:
    """Remove what killed trainings have left in a folder; nothing where one goes on, or where it cannot be.

    One that was killed as it began leaves no run: without a mark of ours, files in its folder are others'.

    Raises:
        OSError: the folder cannot be listed.
    """
    if any((run / name).exists() for name in (NAME, LOCK)) or (is_run and _partial_files(run)):
        with suppress(UserError, OSError), locked(run):
            pass


def holder(run: Path) -> int | None:
    """The process that trains the run; None when there is none, also when it was killed and left its file."""
    try:
        told = read_json(run / NAME)
        process = psutil.Process(int(told["process"]))
        # Numbers of processes are used again: the moment of its start tells another one apart.
        if "mark" in told:
            same = lives(str(told["mark"]))
        else:  # Of former versions, by the clock.
            same = abs(process.create_time() - float(told["began"])) < 1.0
        return process.pid if same and process.status() != psutil.STATUS_ZOMBIE else None
    except (OSError, ValueError, KeyError, TypeError, psutil.Error):
        return None
