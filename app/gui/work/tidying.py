"""Tidying off the window's thread: at rest, free memory goes back to the system; at the start, what killed
windows and their trainings have left is cleared away."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator
from contextlib import suppress
from itertools import chain
from pathlib import Path

from app.gui.work.batching import NAMED
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


def clear_places(places: Places) -> Iterator[None]:
    """Answers with nothing: sets of files that were whole are complete, the rest is gone.

    What living processes are writing stays, as does what cannot be moved.
    """
    clear_blocks()
    # An export of several files has a folder of its own, as each run has.
    exports, runs = _folders_in(places.pictures), _folders_in(places.runs)
    for folder in (places.config, places.pictures, *exports, places.runs, *runs):
        clear(folder)
    for run in runs:
        with suppress(OSError):
            clear_training(run, is_run=RunFolder(run).is_run)
    yield None


def clear_results(folders: frozenset[Path]) -> Iterator[None]:
    """The same in all of the batches whose results lie in these folders; they are as deep as their inputs."""
    for batch in chain.from_iterable(folder.glob(f"{NAMED}*") for folder in folders):
        for folder, _, _ in os.walk(batch):
            clear(Path(folder))
    yield None


def _folders_in(folder: Path) -> list[Path]:
    """In their order; none where the system does not let us look."""
    with suppress(OSError):
        inside = sorted(folder.iterdir()) if folder.is_dir() else []
        return [path for path in inside if path.is_dir() and not path.is_symlink()]
    return []
