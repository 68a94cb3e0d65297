"""What is written when a person asks for it: exports, and files that are enhanced together. A part of the
state."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from app.exports.exporting import ExportRequest
from app.exports.sizing import Sizing
from app.gui.state.pace import Pace
from app.gui.work.batching import BatchRequest, Progressed


@dataclass
class Exports:
    """What is exported and how large, as chosen. Export actions change it; drawing reads it."""

    shown: bool = False
    """Its panel."""
    sizing: Sizing = field(default_factory=Sizing)
    """Of the panes."""
    view_size: tuple[int, int] | None = None
    """Pixels of the 3D view in files; None: its shape on screen, no smaller than the clip's frames."""
    supersampling: int = 1
    """Of the 3D view in files, one of FACTORS."""
    settling: int = 0
    """Frames until the whole window is saved as it then is; 0: that is not asked for."""
    under_way: ExportRequest | None = None
    pace: Pace = field(default_factory=Pace)
    """Steps of it that are done, and how fast."""

    @property
    def done(self) -> int:
        """Steps of it."""
        return self.pace.done

    @property
    def is_busy(self) -> bool:
        """Something goes on that the window should follow closely."""
        return self.under_way is not None or self.settling > 0


@dataclass
class Batches:
    """Files and folders that are enhanced together, and how far that is. Batch actions change it."""

    shown: bool = False
    """Its panel."""
    inputs: tuple[Path, ...] = ()
    folder: Path | None = None
    """Where the folder of the results is made; None: among the saved pictures."""
    under_way: BatchRequest | None = None
    progressed: Progressed | None = None
    """Of the batch under way, or of the last one."""
