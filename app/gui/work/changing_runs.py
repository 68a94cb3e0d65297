"""Runs renamed and deleted off the window's thread, and what deleting one would free."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from app.runs.run_changes import Footprint, delete_run, footprint, rename_run


@dataclass(frozen=True, eq=False)
class ChangeRequest:
    """One run to be renamed, or deleted."""

    path: Path
    name: str | None
    """The new one; None: it is deleted."""
    for_good: bool = False
    """Delete at once, not into the system's bin."""


def change_run(request: ChangeRequest) -> Iterator[Path | None]:
    """Where it lies now; None: nowhere. Raises OSError or UserError."""
    if request.name is None:
        delete_run(request.path, for_good=request.for_good)
        yield None
    else:
        yield rename_run(request.path, request.name)


def measure_folder(path: Path) -> Iterator[Footprint]:
    """Of a run. Raises OSError or UserError."""
    yield footprint(path)
