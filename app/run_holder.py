"""Which process trains a run: a small hidden file in its folder for as long as it does."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil

from app.atomic import write_bytes
from app.errors import UserError

NAME = ".training.json"


@contextmanager
def held(run: Path) -> Iterator[None]:
    """Nobody else trains the run meanwhile. Raises UserError when another process does."""
    other = holder(run)
    if other is not None:
        raise UserError(f"the run is being trained by another process, {other}: {run}")
    file, process = run / NAME, psutil.Process()
    write_bytes(file, json.dumps({"process": process.pid, "began": process.create_time()}).encode())
    try:
        yield
    finally:
        file.unlink(missing_ok=True)


def holder(run: Path) -> int | None:
    """The process that trains the run; None when there is none, also when it was killed and left its file."""
    try:
        told = json.loads((run / NAME).read_bytes())
        process = psutil.Process(int(told["process"]))
        # Numbers of processes are used again: the moment of its start tells another one apart.
        same = abs(process.create_time() - float(told["began"])) < 1.0
        return process.pid if same and process.status() != psutil.STATUS_ZOMBIE else None
    except (OSError, ValueError, KeyError, TypeError, psutil.Error):
        return None
