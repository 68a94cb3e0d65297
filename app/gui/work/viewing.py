"""The 3D view as a request by value and its answer, and the drawing of it by the numba rasteriser."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

from app.drawing import Drawn, draw_on_cpu
from app.gui.views.free_view import FreeView
from app.gui.work.origin import Origin
from app.gui.work.photos import Photo
from app.supersampling import supersampled
from app.views import SCENE_UNITS, SHAPES, Composed, Scale, ViewKind, composed, splats_for
from renderer.camera import Camera
from renderer.clip import ByteImage, Clip
from renderer.editing.edits import Edits
from renderer.gaussians import DynamicGaussians
from renderer.near_plane import NEAR_SHARE
from renderer.splats import RenderMode

BACKGROUND = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class ShownModel:
    """A model with what is needed to look at it and to say what it is."""

    model: DynamicGaussians
    cameras: tuple[Camera, ...]
    """Of its clip, one a frame."""
    distance: float
    """From the first camera to the middle of the tissue, along its axis."""
    name: str
    iteration: int
    iterations: int
    """0 for a file of splats."""
    live: bool
    """Not finished: still being trained, or cut short."""
    origin: Origin | None = None
    """The run or file it comes from; None when that left nothing to read."""
    mode: RenderMode = "default"
    unit: str = SCENE_UNITS
    """Of lengths."""
    first: int | None = None
    """The frame of the open clip that its first one is, of a run of a part; None: it is of all frames."""
    saved_edits: Edits | None = None
    """What was saved of edits of `model`, which is without them."""

    @property
    def start(self) -> int:
        """The frame of the open clip that its first one is."""
        return self.first or 0

    def frame_at(self, time: float) -> int:
        """The frame of the clip that is nearest to `time` in [0, 1]."""
        return min(int(time * len(self.cameras) + 0.5), len(self.cameras) - 1)

    def number_at(self, time: float) -> float:
        """Of the clip's frames, counted from 1, the one at `time` in [0, 1]; between two a fraction."""
        return round(1 + self.start + time * len(self.cameras), 2)

    def time_of(self, number: float) -> float:
        """In [0, 1], of a frame of the clip counted from 1, or of a moment between two."""
        return (number - 1 - self.start) / len(self.cameras)

    def moment(self, time: float) -> str:
        """`time` in [0, 1] as a person says it."""
        return f"frame {self.number_at(time):g}"

    def form(self, time: float) -> str:
        """How a control writes that number: with decimals only between two frames."""
        return "%.0f" if self.number_at(time).is_integer() else "%.2f"

    def camera_at(self, time: float) -> Camera:
        """The clip's own, of the frame nearest to `time`."""
        return self.cameras[self.frame_at(time)]

    def snapped(self, time: float) -> ViewRequest:
        """The frame nearest to `time` as the clip's camera took it: moment, pose, lens, pixels."""
        return self.of_frame(self.frame_at(time))

    def of_frame(self, frame: int) -> ViewRequest:
        """That frame as the clip's camera took it."""
        return ViewRequest(self, frame / len(self.cameras), self.cameras[frame])

    def of_clip_frame(self, frame: int) -> ViewRequest:
        """That frame of the open clip; of those before and after its own, the nearest."""
        return self.of_frame(min(max(frame - self.start, 0), len(self.cameras) - 1))

    def has_clip_frame(self, frame: int) -> bool:
        return 0 <= frame - self.start < len(self.cameras)

    def is_of(self, clip: Clip) -> bool:
        """Its cameras are those of the clip, or of a part of it."""
        if self.first is None:
            return self.cameras == clip.cameras
        return self.cameras == clip.cameras[self.first : self.first + len(self.cameras)]

    def view(self, time: float, free: FreeView | None, size: tuple[int, int]) -> ViewRequest:
        """The view of (width, height) pixels at `time` in [0, 1]: the free one, or that of the clip's camera.

        The photo's whole field stays in view, whatever the shape of the view.
        """
        camera = self.camera_at(time) if free is None else free.camera
        return ViewRequest(self, time, camera.fitted(*size))


@dataclass(frozen=True)
class ViewRequest:
    """Everything that the 3D picture depends on."""

    shown: ShownModel
    time: float
    camera: Camera
    reduced: bool = False
    """Drawn with fewer pixels than the screen has, to keep up with the hand."""
    kind: ViewKind = "color"
    photo: Photo | None = None
    """Of the same frame, where the view is the difference to it."""
    supersampling: int = 1
    """Drawn with so many times as many pixels each way, and averaged."""
    scale: Scale | None = None
    """Of its values; None: that which holds those of this picture."""

    @property
    def near(self) -> float:
        """The near plane in scene units, the same share of the scene as in training."""
        return NEAR_SHARE * self.shown.distance

    def of_kind(self, kind: ViewKind, photo: Photo | None = None) -> ViewRequest:
        """The same camera and time shown otherwise; a difference without its photo stays in colour."""
        if kind == "difference":
            return self if photo is None else replace(self, kind=kind, photo=photo)
        return replace(self, kind=kind)

    def composed(self, drawn: Drawn) -> Composed:
        """The picture that is asked for, of its splats drawn in their shape."""
        photo = self.photo.image if self.photo else None
        return composed(self.kind, drawn, self.shown.unit, photo, self.scale)

    def scaled(self, scale: float) -> ViewRequest:
        """The same view with fewer pixels."""
        width = max(1, round(self.camera.width * scale))
        height = max(1, round(self.camera.height * scale))
        return replace(self, camera=self.camera.resized(width, height), reduced=True)


@dataclass(frozen=True, eq=False)
class View:
    """The 3D picture on screen, with the request it was made from."""

    request: ViewRequest
    image: ByteImage
    """(H, W, 3)."""
    milliseconds: float
    scale: Scale | None = None
    """What its colours mean, where they are values."""


def view_facts(request: ViewRequest) -> dict[str, Any]:
    """What an export says of it: its own run and clip, which need not be those of the pictures beside it."""
    return lasting_facts(request) | moment_facts(request)


def lasting_facts(request: ViewRequest) -> dict[str, Any]:
    """What is so at every moment of a video: the model, and how it is drawn."""
    shown = request.shown
    origin = shown.origin.facts if shown.origin else {"run": {"name": shown.name}}
    return origin | {
        "iteration": shown.iteration,
        "near": request.near,
        "background": BACKGROUND,
        "renderer": "numba on the CPU",
        "supersampling": request.supersampling,
        "view": request.kind,
        "scale": request.scale,
    }


def moment_facts(request: ViewRequest) -> dict[str, Any]:
    """When, and from where it is seen."""
    return {
        "time": request.time,
        "camera": request.camera.to_json(),
        "frame": request.shown.frame_at(request.time),
    }


def draw_view(request: ViewRequest) -> Iterator[View]:
    """Answers a ViewRequest with the numba rasteriser."""
    start = perf_counter()
    shown = request.shown
    splats = splats_for(request.kind, shown.model, request.time, request.camera)
    draw = supersampled(draw_on_cpu, request.supersampling)
    drawn = draw(splats, request.camera, request.near, shown.mode, SHAPES[request.kind])
    picture = request.composed(drawn)
    yield View(request, picture.image, 1000 * (perf_counter() - start), picture.scale)
