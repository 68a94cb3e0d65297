"""Tidying off the window's thread: memory that what was open before had needed goes back to the system, and
what killed windows and their trainings have left is cleared away at the start."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from app.gui.work.settings import Places
from app.runs.memory import give_back
from app.runs.run_lock import clear_training
from app.runs.shared_model import clear_blocks
from renderer.clip import Clip
from renderer.leftovers import clear


@dataclass(frozen=True)
class OnScreen:
    """What has been opened."""

    path: Path | None
    clip: Clip | None


def tidy(request: OnScreen) -> Iterator[None]:
    """Answers with nothing: the system has the memory."""
    give_back()
    yield None


def clear_places(places: Places) -> Iterator[None]:
    """Answers with nothing: sets of files that were whole are complete, the rest is gone.

    What living processes are writing stays, as does what cannot be moved.
    """
    clear_blocks()
    clear(places.config)
    # Batches write folders of their own into that of the pictures.
    for folder, below, _ in os.walk(places.pictures):
        below[:] = [name for name in below if not name.startswith(".")]
        clear(Path(folder))
    clear(places.runs)
    for run in sorted(places.runs.iterdir()) if places.runs.is_dir() else ():
        if run.is_dir() and not run.is_symlink():
            clear(run)
            clear_training(run)
    yield None
