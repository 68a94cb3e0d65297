"""How a sweep's folder is known, without loading what runs one."""

from __future__ import annotations

from pathlib import Path
from typing import Final

SWEEP: Final = "sweep.json"
JOBS: Final = "jobs"
"""In a sweep's folder: which jobs it has, in order; and the folder of all jobs."""


def is_sweep(path: Path) -> bool:
    return (path / SWEEP).is_file()


def is_in_sweep(path: Path, below: Path) -> bool:
    """Whether a path below `below` is the folder of a sweep or of its jobs, or lies in one."""
    places = [path, *path.parents][: len(path.relative_to(below).parts)]
    return any(is_sweep(place) or (place.name == JOBS and is_sweep(place.parent)) for place in places)
