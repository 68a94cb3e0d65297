"""The 3D view as a request by value and its answer, and the drawing of it by the numba rasteriser."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from app.gui.free_view import FreeView
from app.gui.origin import Origin
from renderer.camera import Camera
from renderer.clip import ByteImage
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
    """Still being trained."""
    origin: Origin | None = None
    """The run or file it comes from; None when that left nothing to read."""
    mode: RenderMode = "default"

    def frame_at(self, time: float) -> int:
        """The frame of the clip that is nearest to `time` in [0, 1]."""
        return min(int(time * len(self.cameras) + 0.5), len(self.cameras) - 1)

    def camera_at(self, time: float) -> Camera:
        """The clip's own, of the frame nearest to `time`."""
        return self.cameras[self.frame_at(time)]

    def snapped(self, time: float) -> ViewRequest:
        """The frame nearest to `time` as the clip's camera took it: moment, pose, lens, pixels."""
        frame = self.frame_at(time)
        return ViewRequest(self, frame / len(self.cameras), self.cameras[frame])

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

    @property
    def near(self) -> float:
        """The near plane in scene units, the same share of the scene as in training."""
        return NEAR_SHARE * self.shown.distance

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


def draw_view(request: ViewRequest) -> Iterator[View]:
    """Answers a ViewRequest with the numba rasteriser."""
    # Its kernels take seconds to import on a first start; the window must not wait for them.
    from renderer.rasterize.cpu import render

    start = perf_counter()
    shown = request.shown
    splats = shown.model.at(request.time)
    rendered = render(splats, request.camera, BACKGROUND, near=request.near, mode=shown.mode)
    image = np.rint(np.clip(rendered.image, 0, 1) * 255).astype(np.uint8)
    yield View(request, image, 1000 * (perf_counter() - start))
