"""Files and folders that are enhanced together, and how far that is. A part of the state."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from app.gui.work.batching import BatchRequest, Progressed


@dataclass
class Batches:
    """Batch actions change it; drawing reads it."""

    shown: bool = False
    """Its panel."""
    inputs: tuple[Path, ...] = ()
    folder: Path | None = None
    """Where the folder of the results is made; None: among the saved pictures."""
    under_way: BatchRequest | None = None
    progressed: Progressed | None = None
    """Of the batch under way, or of the last one."""
