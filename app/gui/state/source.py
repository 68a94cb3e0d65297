"""What is open: a clip, a run or a file of splats; what of the clip counts, and where it stands; a report. A
part of the state."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

from app.gui.work.depths import DepthRequest
from app.gui.work.neighbours import Neighbours
from app.gui.work.opening import Content, OpenRequest
from app.gui.work.reported import Reported
from app.gui.work.settings import KnownClip
from app.gui.work.strip import Strip
from app.gui.work.swept import SweptImage, SweptJob
from app.live.picture import LIVE
from app.runs.clip_selection import WHOLE, ClipPart
from app.runs.tool_masks import ToolMasks
from renderer.clip import Clip
from renderer.depth.depth_ways import DepthWays
from renderer.readers.clip_options import DEFAULTS, ClipOptions


@dataclass
class Source:
    """Opening and clip actions change it; drawing reads it."""

    clip_options: ClipOptions = DEFAULTS
    """How clips are read, as said at the start."""
    opening: OpenRequest | None = None
    path: Path | None = None
    """The clip, run or file of splats that was opened last."""
    clip: Clip | None = None
    content: Content | None = None
    """What was opened last; None before."""
    asked: bool = True
    """The panel of its pictures is to come to the front, at the start as well."""
    bare: Clip | None = None
    """`clip` with no depth but that of its own files."""
    is_enhanced: bool = False
    """`clip` is a file that VesselSplat enhanced before."""
    is_dicom: bool = False
    """It is a DICOM file."""
    notices: tuple[str, ...] = ()
    """Of the video that is open, what it is read as; none once that has been read."""
    options: ClipOptions = DEFAULTS
    """How `clip` was read."""
    depth_ways: DepthWays | None = None
    """Where its depth can come from; None until that is known."""
    depth_wish: DepthRequest | None = None
    """The clip with other depth, until it is there."""
    neighbours: Neighbours = field(default_factory=Neighbours)
    """Of the image that is open, or was; it is one of them where they are its."""
    part: ClipPart = WHOLE
    """Trim and mask of the open clip."""
    tool_masks: ToolMasks | None = None
    """Those that were made of the open clip in the window; None: none."""
    known: dict[str, KnownClip] = field(default_factory=dict)
    """Those of all clips, by path, and the depth that was chosen for them."""

    @property
    def is_live_frame(self) -> bool:
        """What is open is a live source, or a frame of one: no file, and no clip to work on."""
        return self.clip is not None and self.clip.format == LIVE

    @property
    def span(self) -> tuple[int, int]:
        """First and last frame that count."""
        return self.part.span(1 if self.clip is None else len(self.clip))

    @property
    def training_part(self) -> ClipPart:
        """What of the open clip the next reconstruction is of."""
        return replace(
            self.part,
            trim=self.span if self.part.trim else None,
            field_of_view=None,
            tools=None,
            tool_masks=self.tool_masks or self.part.tool_masks,
        )

    @property
    def place(self) -> int | None:
        """Of a single image that is open, among those of its folder; None where it has none beside it."""
        single = self.clip is not None and self.clip.format == "image"
        return self.neighbours.place(self.path) if single and len(self.neighbours.images) > 1 else None

    @property
    def reading(self) -> ClipOptions:
        """How the open clip is read, or will be in a moment."""
        return self.options if self.depth_wish is None else self.depth_wish.options

    def first_options(self, path: Path) -> ClipOptions:
        """With which to open it: as said at the start, else the eyes and lens that were chosen for it."""
        known, said = self.known.get(str(path)), self.clip_options
        if known is None:
            return said
        stereo = known.stereo if said.stereo == DEFAULTS.stereo else said.stereo
        return replace(said, stereo=stereo, calibration=said.calibration or known.calibration)

    def kept_options(self, path: Path, options: ClipOptions) -> ClipOptions:
        """Of a clip that was read with `options`: as said at the start, else as it was chosen for it."""
        known, said = self.known.get(str(path)), self.clip_options
        depth, baseline, view = said.depth, said.baseline, said.field_of_view
        if known is not None:
            depth = known.depth if depth == DEFAULTS.depth else depth
            baseline = known.baseline if baseline is None else baseline
            view = known.view_angle if view is None else view
        return replace(options, depth=depth, baseline=baseline, field_of_view=view)


@dataclass
class Timeline:
    """Where the open clip stands and whether it plays, with its frame strip. Time's actions change it."""

    frame_index: int = 0
    frozen_index: int | None = None
    """The frame that the pictures hold while the clip's time goes on."""
    playing: bool = False
    playhead: float = 0.0
    """Position in frames while playing; frame_index is its whole part."""
    pace: float = 1.0
    """Seconds of the clip that have played in a second, lately: less than 1 on a computer too slow for it."""
    strip: Strip | None = None
    strip_count: int = 0
    """Small pictures that fit into the frame strip, as last laid out."""

    @property
    def shown_index(self) -> int:
        """Frame of the two pictures."""
        return self.frame_index if self.frozen_index is None else self.frozen_index


@dataclass
class Reports:
    """The report that is shown. Actions change it; drawing reads it."""

    shown: Reported | None = None
    place: int = 0
    """Which diagram of it is shown."""
    asked: bool = False
    """Its panel is to come to the front."""
    axes: tuple[str, str] | None = None
    """Of a sweep's jobs, across and up; None: those to begin with."""
    job: SweptJob | None = None
    """Of a sweep, the one that was clicked."""
    image: SweptImage | None = None
    """Of that job, once it is read."""
