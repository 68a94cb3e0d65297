"""Tidying off the window's thread: at rest, free memory goes back to the system; at the start, what killed
windows and their trainings have left is cleared away."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from app.gui.work.settings import Places
from app.runs.memory import give_back
from app.runs.run_folder import RunFolder
from app.runs.run_lock import clear_training
from app.runs.shared_model import clear_blocks
from renderer.leftovers import clear


def rest() -> None:
    """What only refers to itself is freed before: a decoded frame is a few objects to Python, which does not
    hurry for them, and megabytes."""
    gc.collect()
    give_back()


def clear_below(root: Path) -> None:
    """A folder and those in it, whoever has left something there."""
    for folder, below, _ in os.walk(root):
        below[:] = [name for name in below if not name.startswith(".")]
        clear(Path(folder))


def clear_places(places: Places) -> Iterator[None]:
    """Answers with nothing: sets of files that were whole are complete, the rest is gone.

    What living processes are writing stays, as does what cannot be moved.
    """
    clear_blocks()
    clear(places.config)
    # Batches write folders of their own into that of the pictures.
    clear_below(places.pictures)
    clear(places.runs)
    for run in sorted(places.runs.iterdir()) if places.runs.is_dir() else ():
        if run.is_dir() and not run.is_symlink():
            clear(run)
            with suppress(OSError):
                clear_training(run, is_run=RunFolder(run).is_run)
    yield None
