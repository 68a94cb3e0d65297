"""What files say of a scene that they show: its model, when, from where, and how it is drawn."""

from __future__ import annotations

from dataclasses import fields
from typing import Annotated, Any, Literal

from annotated_types import Interval
from pydantic import PlainSerializer, PlainValidator
from pydantic.dataclasses import dataclass

from app.enhancement.settable import Share
from app.enhancement.setting_words import worded
from app.files.provenance import plain, repeatable
from app.files.records import LENIENT, Record, Source, Told
from app.runs.clip_selection import ClipPart
from app.runs.run_edits import RecordedEdits
from app.runs.run_folder import Enhancement, Input
from app.scenes.backgrounds import Background
from app.scenes.view_kinds import Scale, ViewKind
from renderer.camera import Camera
from renderer.readers.lenses.calibration import Calibration
from renderer.splats import RenderMode
from renderer.train.config import TrainConfig
from renderer.unobserved import BLACK

Ends = Literal["image", "field", "even"]
"""Of tissue in views from elsewhere than the endoscope was. That of a camera at rest ends at the sides of its
image, as in 0.7.0, or of its field of view, as in 0.8.0. "even": there, too, and of any camera edges are even
and small gaps closed, see renderer/closing.py."""


def _camera(given: Any) -> Camera:
    return given if isinstance(given, Camera) else Camera.from_json(given)


RecordedCamera = Annotated[Camera, PlainValidator(_camera), PlainSerializer(Camera.to_json)]


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class RunSource(Record):
    """A run folder."""

    name: str
    model_sha256: str | None = None
    """None: the model is still being trained."""


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class ClipSource(Source):
    """The clip that a run was trained on."""

    part: ClipPart | None = None
    """None: all of it."""
    calibration: Calibration | None = None
    """By which its images are undistorted."""


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class SceneRecord(Record):
    """A model: that of a run, or of a file of splats."""

    run: RunSource | None = None
    clip: Annotated[ClipSource | None, Told] = None
    input: Annotated[Input | None, Told] = None
    enhancement: Annotated[Enhancement | None, Told] = None
    config: Annotated[TrainConfig | None, Told] = None
    splats: Source | None = None
    render_mode: Annotated[RenderMode | None, Told] = None
    """Of a file of splats."""
    notices: Annotated[tuple[str, ...] | None, Told] = None
    edits: RecordedEdits | None = None
    window: Annotated[int, Interval(ge=1)] | None = None
    """Of a model in windows the one that it is, counted from 1; None: all of them."""

    @property
    def signed(self) -> dict[str, Any]:
        """Without the hour: what is drawn of a model at exact moments and poses is the same file every
        time."""
        return repeatable(**plain(self))

    @property
    def trained_on(self) -> str:
        """The frames that it is a reconstruction of, in words; empty where that is not known."""
        if self.enhancement is not None:
            return f"frames enhanced by {worded(self.enhancement.params)}"
        return f"{self.input} frames" if self.input else ""

    @property
    def scene(self) -> SceneRecord:
        """The model alone, without when it is seen and how."""
        return SceneRecord(**{field.name: getattr(self, field.name) for field in fields(SceneRecord)})


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class MomentRecord(Record):
    """When, and from where it is seen."""

    time: Share
    camera: RecordedCamera
    frame: int | None = None
    near: float | None = None
    """In scene units; None: as at the other moments."""


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class DrawnRecord(SceneRecord):
    """How a scene is drawn at every moment of a video."""

    iteration: Annotated[int | None, Told] = None
    near: float | None = None
    """In scene units; None: the near plane of the scene."""
    background: Background | None = BLACK
    """Where nothing was observed; None: alpha says where."""
    unobserved: bool = True
    """With what no frame shows, as always before 0.7.0."""
    ends: Ends = "image"
    """How it ends, without what no frame shows."""
    renderer: str
    supersampling: Annotated[int, Interval(ge=1, le=16)] = 1
    view: ViewKind = "color"
    frame_share: Share | None = None
    """Of the clip's frame over the view; None: nothing lies over it."""
    scale: Scale | None = None
    caption: str | None = None
    """Above it on a page of several; None: as before 0.2.0, the model's name."""


@dataclass(frozen=True, kw_only=True, config=LENIENT)
class ViewRecord(DrawnRecord, MomentRecord):
    """A scene as it is drawn at one moment."""

    start: Annotated[int | None, Told] = None
    """The frame of the clip, from 0, that the scene's first one is; None: not told, or its first."""
