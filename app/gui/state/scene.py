"""What the 3D view shows, from where, and of when; and the second one beside it. A part of the state."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

from app.gui.views.measurement import Measurement
from app.gui.work.baking import Baked
from app.gui.work.clip_scale import ClipScale, ScaleRequest
from app.gui.work.opening import OpenRequest
from app.gui.work.selecting import PickRequest
from app.scenes.drawer import View
from app.scenes.free_camera import FreeView, Vector
from app.scenes.scene import Scene
from app.scenes.view_kinds import BY_PROCESSOR, Scale, ViewKind
from app.scenes.view_request import FrameImage, ViewRequest
from renderer.draw.keyframes import Keyframes
from renderer.view_files import Views

MIN_SPEED, MAX_SPEED = 0.02, 4.0


@dataclass
class Viewer:
    """Where the 3D view is seen from, and what the hand does there. Camera actions change it."""

    free: FreeView | None = None
    """None: the clip's own camera, at every time."""
    snapped: bool = False
    """The clip's camera with its own pixels, under its frame."""
    blend: float = 0.5
    """Share of the frame in a snapped view, in [0, 1]."""
    frame_image: FrameImage | None = None
    """The newest frame for a snapped view."""
    pivot: Vector | None = None
    """What the view turns around; None: the middle of the tissue, until the view leaves the clip's camera."""
    flying: bool = False
    speed: float = 0.3
    """Of flight: the scene's distance so many times a second."""
    moving: bool = False
    """A key of flight is held."""
    measuring: bool = False
    """A click on the view picks a point of a distance."""
    measurement: Measurement = field(default_factory=Measurement)
    pick: PickRequest | None = None
    """The newest wish for a point on the surface."""

    def renewed(self) -> Viewer:
        """The same camera on another model, of which nothing is measured yet."""
        return replace(self, moving=False, measuring=False, measurement=Measurement(), pick=None)


@dataclass
class CameraList:
    """Named views and the camera path of what is open. Path actions change it."""

    views: Views = field(default_factory=Views)
    playing: bool = False
    """The path moves the 3D view."""
    playhead: float = 0.0
    """Seconds on the path."""
    path_shown: bool = True
    """The path is drawn in the 3D view."""
    name: str = ""
    """Typed for the next named view."""


@dataclass
class Viewed:
    """A reconstruction in a 3D view, and what is drawn of it."""

    model: Scene | None = None
    view: View | None = None
    """The newest picture of it that the processor drew."""
    baked: Baked | None = None
    """Keyframes for the graphics card, of `model` or of one before it; more to come while they are None."""

    def keyframes_of(self, drawn: Scene | None) -> Keyframes | None:
        """Once they are there; none of `model` with a selection in colour."""
        baked = self.baked
        return baked.keyframes if baked is not None and baked.request.shown is drawn else None


@dataclass
class Second(Viewed):
    """Another reconstruction with the first one's camera and time. Second actions change it."""

    opening: OpenRequest | None = None


@dataclass
class ShownScene(Viewed):
    """View, camera and path actions change it; drawing reads it."""

    kind: ViewKind = "color"
    clip_scale: ClipScale | None = None
    """The newest scale that holds for all of the clip."""
    size: tuple[int, int] = (0, 0)
    """Pixels of the 3D view, as last laid out; (0, 0) while it is hidden."""
    dragged: bool = False
    viewer: Viewer = field(default_factory=Viewer)
    cameras: CameraList = field(default_factory=CameraList)
    second: Second = field(default_factory=Second)
    models: tuple[Path, ...] = ()
    """Of what was opened lately, what can be seen beside the first."""
    linked: bool = True
    """The 3D view follows the clip's frame."""
    own_time: float = 0.0
    """In [0, 1]; used when not linked."""
    processor_draws: bool = True
    """The numba rasteriser draws the 3D view, since there is no graphics card, or OpenGL is slower."""
    drawn_by: str = ""
    """Why, for the tooltip."""

    @property
    def is_drawn_by_processor(self) -> bool:
        """What is shown now."""
        return self.processor_draws or self.kind in BY_PROCESSOR

    @property
    def steady_scale(self) -> Scale | None:
        """Of what the clip's camera sees, at whatever time; None where it is not known, and for a free
        camera, which sees other depths."""
        known = self.clip_scale
        if known is None or known.request != (ScaleRequest(self.model, self.kind) if self.model else None):
            return None
        return None if self.kind == "depth" and self.viewer.free is not None else known.scale

    def beside(self, first: ViewRequest) -> ViewRequest | None:
        """The second reconstruction at the moment of `first` through its camera; None without one.

        A frame is of the first one's frames: where the second has others, its difference to them is none.
        """
        shown = self.second.model
        if shown is None:
            return None
        if first.kind == "difference" and not self.has_frames_of(first):
            return replace(first, scene=shown, kind="color", reference=None)
        return replace(first, scene=shown)

    def has_frames_of(self, first: ViewRequest) -> bool:
        """The second reconstruction has the frames of the first one."""
        shown = self.second.model
        return shown is not None and (shown.first, shown.cameras) == (first.scene.first, first.scene.cameras)
