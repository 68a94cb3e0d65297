"""What is written when a person asks for it: exports, and files that are enhanced together. A part of the
state."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from app.exports.exporting import ExportRequest
from app.exports.sizing import Sizing
from app.files.dicom.choices import DEIDENTIFIED, DicomChoices
from app.files.video_encoder import VideoEncoder
from app.gui.state.pace import Pace
from app.gui.work.batching import BatchRequest, Progressed
from app.gui.work.naming import NameRequest

What = Literal[
    "panes and 3D view",
    "panes as shown",
    "left pane",
    "right pane",
    "both panes",
    "3D view",
    "window",
    "enhanced frame",
    "video of the panes",
    "video of the right pane",
    "video of both panes",
    "enhanced clip",
    "video through time",
    "video along the path",
    "measures of both panes",
    "splats of this moment",
    "splats of all frames",
    "splats through time",
    "page for browsers",
    "surface through time",
    "surface of all frames",
    "arrays of all frames",
    "tracks of the measured points",
    "cameras of the clip",
    "cameras of the path",
]


@dataclass
class Exports:
    """What is exported and how large, as chosen. Export actions change it; drawing reads it."""

    shown: bool = False
    """Its panel."""
    what: What = "panes and 3D view"
    name: str = ""
    """As a person has typed it, without suffix; empty: what it is of says it."""
    formats: dict[str, str] = field(default_factory=dict)
    """Suffixes that were chosen, by the form of an offer; the first of its formats otherwise."""
    dicom: DicomChoices = DEIDENTIFIED
    """Of DICOM files."""
    quality: int = 95
    """Of JPEG images, 1 to 100."""
    sh_degree: int | None = None
    """To which colours by direction are filled up in splat files; None: as the model has them."""
    unobserved: bool = True
    """Splat files hold Gaussians that no frame shows, too."""
    sizing: Sizing = field(default_factory=Sizing)
    """Of the panes."""
    view_size: tuple[int, int] | None = None
    """Pixels of the 3D view in files; None: its shape on screen, no smaller than the clip's frames."""
    supersampling: int = 1
    """Of the 3D view in files, one of FACTORS."""
    settling: int = 0
    """Frames until the whole window is saved as it then is; 0: that is not asked for."""
    saving: tuple[ExportRequest, ...] = ()
    """Images of what is shown that are still to be written."""
    under_way: ExportRequest | None = None
    pace: Pace = field(default_factory=Pace)
    """Steps of it that are done, and how fast."""
    count: int = 0
    """Files that were written."""
    last: Path | None = None
    """The newest of them, or a folder; None: nothing, or the newest export failed."""
    failure: str = ""
    """Why it did."""
    named: tuple[NameRequest, str] | None = None
    """The newest question for a free name, and the answer."""
    encoder: VideoEncoder | None = None
    """What writes videos here, once that is known."""

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
    under_way: BatchRequest | None = None
    progressed: Progressed | None = None
    """Of the batch under way, or of the last one."""
    written: Path | None = None
    """The folder of the last one's results; None: it has none yet."""
