"""What is compiled once on a computer, in steps: each uses one feature on a small input, as the app would.

A kernel is compiled for the types it is called with, so what a feature needs is prepared by using it: there
is no list of kernels. Tests use every feature after these steps and fail where one needs another kernel.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from typing import Any, Final, get_args

import numpy as np
from numpy.typing import NDArray

from app.enhancement.measures import Original
from app.enhancement.methods import MethodEnhancer, Preset, measure_for
from app.kernels.progress import Kind, Preparation, Task, paced, tasks
from app.kernels.stamp import note_prepared
from app.runs.train_run import PRESETS
from app.scenes.cpu_rendering import DrawOptions, draw_on_cpu
from assets import phantom_path
from renderer.clip import Clip, Frame
from renderer.closing import closed
from renderer.deformation.spline import MIN_CONTROLS
from renderer.deformation.spline_motion import SplineMotion
from renderer.editing.regions import Lasso, found
from renderer.editing.sight import Sight, Trail
from renderer.gaussians import DynamicGaussians
from renderer.in_view import FieldInView
from renderer.near_plane import near_plane
from renderer.picking import surface_point
from renderer.sources import open_clip
from renderer.splats import RenderMode, Shape
from renderer.surface.of_model import surface_of
from renderer.surface.triangles import render_mesh
from renderer.train.config import Method, Part, TrainConfig
from renderer.train.initialize import round_gaussians
from renderer.train.training import train

STEPS: Final = 8
GAUSSIANS: Final = 400
FRAMES: Final = 10
"""Of a training that is quick and reaches every stage."""
SPACING: Final = 6
"""Pixels between Gaussians that are looked at."""
SIDEWAYS: Final = np.array([[1.0, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
"""A camera that has moved by 1 mm."""


def prepare(*first: Kind) -> Iterator[Preparation]:
    """Take all steps, those of the kinds in `first` before the others; before each, and at the end, how far
    it is. Quick where it has been done before."""
    todo = tasks(*first)
    taken: list[float] = []
    for task in todo:
        yield Preparation(todo, len(taken), paced(todo, taken))
        began = time.monotonic()
        use(task)
        taken.append(time.monotonic() - began)
    note_prepared()
    yield Preparation(todo, len(taken), paced(todo, taken))


def use(task: Task) -> None:
    """The feature of this step, once."""
    match task.kind:
        case "training":
            _train(next(method for method in get_args(Method) if method == task.name))
        case "3D view":
            _look()
        case "16 bits":
            _enhance(next(preset for preset in PRESETS if task.name.startswith(preset)), np.uint16)
        case preset:
            _enhance(preset, np.uint8)


@cache
def _clip() -> Clip:
    return open_clip(phantom_path()).between(0, FRAMES - 1)


def _enhance(preset: Preset, dtype: type[np.uint8 | np.uint16]) -> None:
    """With the image's own statistics and those of a clip; of an image with detail, which is measured, of one
    without, and of some that an endoscope sees within a dark surround."""
    params, levels = PRESETS[preset], np.iinfo(dtype).max // 255
    image = (_clip().read_image(0).astype(np.float64) * levels).astype(dtype)
    ramp = (levels * np.linspace(100, 176, image.shape[1])).astype(dtype)
    smooth = np.ascontiguousarray(np.broadcast_to(ramp[:, None], image.shape))
    Original.of(image)
    enhancer = MethodEnhancer()
    for each in (image, smooth, *_surrounded(image)):
        enhancer.show(each)
        enhancer.enhance(params)
        enhancer.enhance(params, statistics=measure_for(params, [(each, None)]))


def _surrounded(image: NDArray[Any]) -> Iterator[NDArray[Any]]:
    """Round, cut off by the border above and below, also with a rim that is nearly dark, with eight corners,
    dented, and two beside each other."""
    height, width = image.shape[:2]
    y, x = (np.abs(at) / min(height, width) for at in np.ogrid[-height // 2 : height - height // 2,
                                                               -width // 2 : width - width // 2])  # fmt: skip
    far = np.hypot(x, y)
    octagon, two = (np.maximum(x, y) < 0.4) & (x + y < 0.56), np.hypot(x - 0.33, y) < 0.27
    dented = (far < 0.4) & ((x > 0.05) | (y < 0.3))
    for seen in (far < 0.4, far < 0.56, octagon, dented, two):
        yield image * seen[..., None].astype(image.dtype)
    dim = np.clip(1 - (far / 0.56) ** 3, 0.06, 1) * (far < 0.56)
    yield (image * dim[..., None]).astype(image.dtype)


def _train(method: Method) -> None:
    """With all that some clips need, and as this clip needs it."""
    clip = replace(_clip(), read_frame=_half_hidden)
    config = TrainConfig(method=method, iterations=STEPS, n_gaussians=GAUSSIANS)
    for keep in (get_args(Part), ()):
        for _ in train(clip, replace(config, keep=keep)):
            pass


def _half_hidden(index: int) -> Frame:
    """As if a tool covered half of the view in all frames but the first."""
    frame = _clip().read_frame(index)
    if index == 0:
        return frame
    tissue = frame.tissue_mask.copy()
    tissue[:, tissue.shape[1] // 2 :] = False
    return replace(frame, tissue_mask=tissue)


def _sheet() -> DynamicGaussians:
    """The tissue of the first frame: a splat file is there to be seen long before anything can be trained."""
    frame = _clip().read_frame(0)
    assert frame.depth is not None
    means = frame.camera.unproject(frame.depth)[::SPACING, ::SPACING].reshape(-1, 3).astype(np.float32)
    count = len(means)
    colors = np.full((count, 3), 0.5, np.float32)
    return DynamicGaussians(round_gaussians(means, np.ones(count), colors, 0.9), _stillness(count))


def _stillness(count: int) -> SplineMotion:
    """A motion by which nothing moves, with all that one can have."""
    return SplineMotion(
        position_controls=np.zeros((count, MIN_CONTROLS, 3), np.float32),
        color_controls=np.zeros((count, MIN_CONTROLS, 3), np.float32),
        opacity_controls=np.zeros((count, MIN_CONTROLS, 1), np.float32),
        node_controls=np.zeros((4, MIN_CONTROLS, 3), np.float32),
        node_indices=np.tile(np.arange(4, dtype=np.int32), (count, 1)),
        node_weights=np.full((count, 4), 0.25, np.float32),
    )


def _look() -> None:
    """A model rendered in every shape and mode, a point of it picked, a part of it selected."""
    model, camera = _sheet(), _clip().cameras[0]
    near = near_plane(model, camera)
    splats = model.at(0.5)
    for mode in get_args(RenderMode):
        surface_point(splats, camera, (camera.width // 2, camera.height // 2), near, mode)
    for shape in get_args(Shape):
        draw_on_cpu(splats, camera, DrawOptions(near, shape=shape))
    field = FieldInView(camera, np.array([(0, 0), (camera.width, 0), (0, camera.height)], np.float64))
    aside = camera.moved(camera.camera_from_world @ SIDEWAYS)
    closed(draw_on_cpu(splats, aside, DrawOptions(near, within=field)), 1)
    for cameras in ((camera,), (camera, aside)):
        render_mesh(surface_of(model, cameras, near).at(0.2), camera, near)
    sight = Sight.of(Trail(model, (0.0, 0.5)), camera, 0.5, near)
    found(Lasso(((0.0, 0.0), (float(camera.width), 0.0), (0.0, float(camera.height)))), sight)
