"""The record of each kind of exported file: written into the file, with all that reproducing it takes."""

from __future__ import annotations

from typing import Annotated, Any, Final, Literal, get_args, get_type_hints

from annotated_types import Interval
from pydantic import Discriminator, TypeAdapter, model_validator
from pydantic.dataclasses import dataclass

from app.enhancement.image_mask import NO_MASK, PictureMask
from app.enhancement.measures import METRICS, Lengths, MeasuredOver
from app.enhancement.methods import RecordedSettings
from app.enhancement.records import EnhancedPicture, EnhancedVideo, TuningSheet
from app.enhancement.settable import (
    LONGEST_NAME,
    LONGEST_NOTES,
    Pixels,
    Scope,
    Share,
    at_most,
    one_of,
    renamed,
)
from app.exports.sizing import LEAST_WIDTH, MOST_SCALE, MOST_WIDTH
from app.files.records import LENIENT, Record, RecordedReading, Source, Told
from app.files.video import Written
from app.scenes.records import DrawnRecord, Ends, MomentRecord, RecordedCamera, SceneRecord, ViewRecord
from enhance import Statistics
from enhance.noise import NoiseCut
from renderer.readers.clip_options import DEFAULTS
from renderer.surface.fineness import VERTICES

MOST_COARSE, MOST_FINE = 100, 2_000_000
"""Vertices of a surface."""
LEAST_FACES: Final = 50
MEASURES_BEFORE: Final = ("dv", "bv", "dv_bv", "vessel_contrast", "noise_gain", "saturated_share")
"""Of tables that do not say which they hold."""
MEASURES: Final = tuple(name for name in METRICS if name != "milliseconds")
"""All but the time, which no picture that is made again has taken."""
Measure = Annotated[str, one_of(MEASURES)]


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class Render(ViewRecord):
    """A picture of a model."""

    kind: Literal["render"] = "render"


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class Depth(ViewRecord):
    """Expected depth, as numbers or in colours."""

    kind: Literal["depth"] = "depth"
    holds: str | None = None
    """What the numbers are."""
    shows: str | None = None
    """What the colours are of, from `nearest` to `farthest`."""
    nearest: Annotated[float | None, Told] = None
    farthest: Annotated[float | None, Told] = None
    step: Annotated[float, Interval(gt=0)] | None = None
    """In scene units, that each whole number of a 16-bit image stands for."""


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class RenderVideo(DrawnRecord):
    """Pictures of a model as a video."""

    kind: Literal["render video"] = "render video"
    frames_per_second: float
    moments: tuple[MomentRecord, ...]
    video: Annotated[Written | None, Told] = None


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class Splats(SceneRecord):
    """A model at a moment as a file of splats."""

    kind: Literal["splats"] = "splats"
    frame: int | None = None
    time: Share
    sh_degree: Annotated[int, Interval(ge=0, le=3)] | None = None
    """To which its colours by direction are filled up; None: as the model has them."""
    unobserved: bool | None = None
    """False: without Gaussians that no frame shows, as views from beside are drawn; None: all."""
    layout: Literal["compressed"] | None = None
    """Of a PLY file: None: that of 3D Gaussian Splatting."""
    clipped: Annotated[tuple[str, ...] | None, Told] = None
    """What the format does not hold, and is written as the nearest that it does, or coarsely, in words."""


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class BrowserModel(SceneRecord):
    """A model over time as one HTML file that a browser plays."""

    kind: Literal["browser model"] = "browser model"
    title: str
    """Of the clip."""
    camera: RecordedCamera
    """By which the page begins."""
    moves: bool = False
    """The page's camera goes as the clip's does."""
    zooms: bool = False
    """The page's lens does so, too; before 0.13.0 it was that of `camera` at all times."""
    near: float
    """In scene units, before which nothing is drawn."""
    unobserved: bool = True
    """With what no frame shows, as always before 0.7.0."""
    ends: Ends = "image"
    """How it ends, without what no frame shows."""
    tolerance: Annotated[float, Interval(ge=0)] | None = None
    """In scene units, to which positions of a motion that is no spline are sampled, as far as the page may
    grow; None: at 48 moments, as before 0.2.0."""
    rounding: Annotated[float, Interval(ge=0)] | None = None
    """In scene units, by which rounding moves positions at most; None: all values of a kind are rounded to a
    share of their range, however wide that is, as before 0.4.0."""
    error: Annotated[float | None, Told] = None
    """In scene units, the largest distance at a frame between positions of the page and of the model; None:
    not measured, as of splines before 0.4.0."""
    clip_frames: Annotated[int, Interval(ge=1)]
    """Of the clip, or of the part of it that was trained on."""
    start: Annotated[int, Interval(ge=0)] | None = None
    """The frame of the clip, from 0, that the first of these is; None: its first."""
    seconds: Annotated[float, Interval(gt=0)]
    """That the clip takes."""


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class SurfaceMesh(SceneRecord):
    """The tissue surface as a mesh: at one moment, or through the clip with one topology."""

    kind: Literal["surface mesh"] = "surface mesh"
    title: str
    """Of the clip."""
    time: Share | None = None
    """None: through the clip."""
    frame: int | None = None
    seconds: Annotated[float, Interval(gt=0)]
    """That the clip takes."""
    vertices: Annotated[int, Interval(ge=MOST_COARSE, le=MOST_FINE)] = VERTICES
    """About, of a picture full of tissue, before simplifying."""
    faces: Annotated[int, Interval(ge=LEAST_FACES)] | None = None
    """To which it is simplified."""


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class MovingSplats(SceneRecord):
    """A model through the clip as one file of splats."""

    kind: Literal["moving splats"] = "moving splats"
    unobserved: bool | None = None
    """False: without Gaussians that no frame shows, as views from beside are drawn; None: all."""
    seconds: Annotated[float, Interval(gt=0)]
    """That the clip takes."""


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class ModelArrays(SceneRecord):
    """A model at several moments as named arrays, with the depth that cameras see."""

    kind: Literal["model arrays"] = "model arrays"
    renderer: str
    """That draws the depth."""
    moments: tuple[MomentRecord, ...]


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class Tracks(SceneRecord):
    """Where points of the surface are at several moments, as a table."""

    kind: Literal["tracks"] = "tracks"
    points: tuple[tuple[int, int], ...] = ()
    """Columns and rows of pixels, from 0, in which they are seen at the start."""
    places: tuple[tuple[float, float, float], ...] = ()
    """Of more points, in the world at the start."""
    start: MomentRecord
    moments: tuple[MomentRecord, ...]


@dataclass(frozen=True, config=LENIENT)
class Arrangement:
    """How panes are set against each other; wipe and difference take two."""

    mode: Literal["side by side", "wipe", "difference"] = "side by side"
    wipe: float = 0.5
    """Where the line stands, as a share of the picture's width."""
    top: int | None = None
    """Grey levels that the brightest colour of a difference stands for; None: what holds this frame's."""


Words = Literal["interface", "method"]


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class PaneRecord(Record):
    """What one pane shows."""

    @model_validator(mode="before")
    @classmethod
    def _of_before(cls, given: Any) -> Any:
        return renamed(given)

    title: str
    shows: Literal["original", "setting", "method", "render"]
    scope: Scope
    pixels: Pixels
    mask: PictureMask = NO_MASK
    span: tuple[int, int] | None = None
    params: RecordedSettings | None = None
    method: str | None = None
    view: ViewRecord | None = None
    drawn_tools: Literal[True] | None = None
    """Tools that were masked in the window do not count; no file holds these masks."""
    given: Statistics | None = None
    """Which it is made with, whatever the scope; None: measured."""
    statistics: Annotated[Statistics | None, Told] = None
    """Of its page, with which `vessel` makes it again."""
    measured: Annotated[dict[str, float | None] | None, Told] = None
    """What the picture's `measures` are of it; None where one cannot be measured."""
    words: Words | None = None
    """How its caption tells the settings: as sliders show them, or so after the name of the method; None: in
    the paper's letters, as before 0.2.0."""


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class FrameRecord(Record):
    """A frame of a clip."""

    index: int
    label: str | None = None


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class PanesRecord(Record):
    """Panes of one clip, how they are laid out, and how large."""

    source: Source | None = None
    """The clip; None where there are no panes."""
    clip_options: RecordedReading = DEFAULTS
    frame: FrameRecord = FrameRecord(index=0)
    """That is shown, or whose difference has the scale of all."""
    scale: Annotated[int, Interval(ge=1, le=MOST_SCALE)] = 1
    width: Annotated[int, Interval(ge=LEAST_WIDTH, le=MOST_WIDTH)] | None = None
    arrangement: Arrangement = Arrangement()
    panes: tuple[PaneRecord, ...] = ()


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class PanesPicture(PanesRecord):
    """Panes, the 3D view, or both: on a page, or in the whole window as it was on a screen."""

    kind: Literal["panes", "window"] = "panes"
    views: tuple[ViewRecord, ...] = ()
    quality: Annotated[int, Interval(ge=1, le=100)] | None = None
    """Of a JPEG, which then keeps all of its colour's resolution."""
    measures: tuple[Measure, ...] | None = None
    """That the file tells of each pane."""
    noise_cut: NoiseCut = "by level"
    """Of the noise gains; by level, as before 0.4.0, of images that do not say."""
    lengths: Lengths = "in pixels"
    """That vessels are measured by; in pixels, as before 0.8.0, of images that do not say."""


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class SpanRecord(PanesRecord):
    """Panes at several frames."""

    first_frame: int
    last_frame: int

    @property
    def frames(self) -> range:
        """Of the clip."""
        return range(self.first_frame, self.last_frame + 1)


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class PanesVideo(SpanRecord):
    """Pages of panes as a video."""

    kind: Literal["panes video"] = "panes video"
    frames_per_second: float = 15.0
    video: Annotated[Written | None, Told] = None


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class MeasuresTable(SpanRecord):
    """Measures of panes at every frame."""

    kind: Literal["measures"] = "measures"
    measures: tuple[Measure, ...] = MEASURES_BEFORE
    """Columns of the table."""
    measured_over: MeasuredOver = "whole image"
    """What DV, BV and the saturated share are of; of tables that do not say, the whole image."""
    noise_cut: NoiseCut = "by level"
    """Of the noise gains; by level, as before 0.4.0, of tables that do not say."""
    lengths: Lengths = "in pixels"
    """That vessels are measured by; in pixels, as before 0.8.0, of tables that do not say."""


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class ViewVideo(Record):
    """The 3D view, and the second one beside it, as a video."""

    kind: Literal["view video"] = "view video"
    views: tuple[DrawnRecord, ...]
    moments: tuple[MomentRecord, ...]
    frames_per_second: float
    video: Annotated[Written | None, Told] = None


MeasuresOf = Literal["panes", "all images"]
"""The latter: of tuned images, too."""


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class SummaryPicture(Record):
    """A picture on a page, by the file that it was saved as."""

    picture: Source
    note: Annotated[str, at_most(LONGEST_NOTES)] = ""


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class CaseSummary(Record):
    """A page to print: pictures that were saved before, with what they are, their measures and notes."""

    kind: Literal["case summary"] = "case summary"
    title: Annotated[str, at_most(LONGEST_NAME)]
    day: str
    """On which it was made, ISO 8601."""
    notes: Annotated[str, at_most(LONGEST_NOTES)] = ""
    """On all of it."""
    pictures: tuple[SummaryPicture, ...]
    measures_of: MeasuresOf = "panes"
    """Whose measures it tells; those of panes alone, as before 0.4.0, where it does not say."""
    layout: Literal["fitted"] | None = None
    """Fitted: narrow screens and sheets of paper hold every image and table as it is; None: as pages that do
    not say it, where a screen or a sheet may be too small."""


Export = (
    EnhancedPicture
    | EnhancedVideo
    | TuningSheet
    | Render
    | Depth
    | RenderVideo
    | Splats
    | BrowserModel
    | SurfaceMesh
    | MovingSplats
    | ModelArrays
    | Tracks
    | PanesPicture
    | PanesVideo
    | MeasuresTable
    | ViewVideo
    | CaseSummary
)
"""What makes a file."""
EXPORT: TypeAdapter[Export] = TypeAdapter(Annotated[Export, Discriminator("kind")])
KINDS = tuple(name for kind in get_args(Export) for name in get_args(get_type_hints(kind)["kind"]))
