"""Error against run time of drawing with OpenGL: targets, depth keys, size, cut-offs; and of keyframes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import cv2
import moderngl
import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.draw.keyframes import Tolerance, baked
from renderer.draw.offscreen import read_image
from renderer.draw.sorting import DepthKeys
from renderer.draw.splat_view import EXACT_CUT, Cut, Precision, SplatView
from renderer.gaussians import DynamicGaussians
from renderer.measuring.drawing_row import Row
from renderer.measuring.interleaved_timing import Laps, interleaved_times, laps
from renderer.splats import Splats

EXPORT: Final = "float target, float32 keys"


@dataclass(frozen=True)
class Setting:
    """How a view is drawn; the default is what exports have."""

    precision: Precision = "float"
    keys: DepthKeys = "float32"
    cut: Cut = EXACT_CUT
    divisor: int = 1
    """Of both sides of the picture."""


SETTINGS: Final[dict[str, Setting]] = {
    EXPORT: Setting(),
    "half target, float32 keys": Setting("half"),
    "8-bit target, float32 keys": Setting("byte"),
    **{f"float target, {bits}-bit keys": Setting(keys=bits) for bits in (8, 10, 12, 16)},
    "half target, 16-bit keys": Setting("half", 16),
    **{f"to {radius:.2f} deviations": Setting(cut=Cut(widest=radius)) for radius in (2.0, 8**0.5, 3.0)},
    **{f"alpha from {levels:g}/255": Setting(cut=Cut(faintest=levels / 255)) for levels in (0.1, 0.5, 2, 4)},
    **{f"float target, 1/{side} along each side": Setting(divisor=side) for side in (2, 4)},
}
EVERY: Final = (1, 2, 4, 8)
"""Frames from one keyframe to the next."""
PIXELS: Final = (0.02, 0.2, 1.0)
"""Tolerances of means."""
BAKES: Final = 3
"""Laps in which the baking is timed."""
MOMENTS: Final = 6
"""At which pictures from keyframes are compared: between frames as well as on them."""


def opengl(
    ctx: moderngl.Context,
    splats: Splats,
    camera: Camera,
    near: float,
    truth: NDArray[np.float64],
    repeats: int = 11,
) -> Iterator[Row]:
    """Rows for one view; `truth` (H, W, 3) is the float64 picture over black. Pictures take turns, and every
    one is uploaded and sorted."""
    works, pictures = [], []
    for one in SETTINGS.values():
        size = camera.width // one.divisor, camera.height // one.divisor
        view = SplatView(ctx, precision=one.precision, keys=one.keys, near=near, cut=one.cut)
        target = ctx.simple_framebuffer(size, 4, dtype="f4")
        work = partial(_drawn, view, target, camera.resized(*size), partial(view.upload, splats))
        works.append(work)
        pictures.append(np.asarray(cv2.resize(work(), (camera.width, camera.height))))
    for name, picture, taken in zip(SETTINGS, pictures, laps(works, repeats), strict=True):
        yield Row.of("OpenGL", name, 255 * np.abs(picture - truth), taken)


def keyframes(
    ctx: moderngl.Context,
    model: DynamicGaussians,
    camera: Camera,
    times: Sequence[float],
    near: float,
    pixel: float,
    repeats: int = 4,
) -> Iterator[Row]:
    """Rows for a model over the clip's `times`, timed in turns; `pixel` is the size of one at its distance,
    in scene units.

    "every moment": what the model is at a time is computed, uploaded and drawn. The others are compared with
    these pictures, at frames and between them.
    """
    target = ctx.simple_framebuffer((camera.width, camera.height), 4, dtype="f4")
    moments = np.linspace(times[0], times[-1], MOMENTS).tolist()
    exact = SplatView(ctx, precision="float", near=near)
    show = [partial(_drawn, exact, target, camera, partial(_upload, exact, model, time)) for time in moments]
    ways = [_Way("every moment", "computed and uploaded", exact, show)]
    settings = [*((every, PIXELS[0]) for every in EVERY), *((1, one) for one in PIXELS[1:])]
    bakes = [
        partial(baked, model, [*times[:-1:every], times[-1]], Tolerance(pixels * pixel))
        for every, pixels in settings
    ]
    for (every, pixels), bake, baking in zip(settings, bakes, laps(bakes, BAKES), strict=True):
        kept = bake()
        view = SplatView(ctx, precision="float", near=near)
        view.upload_keyframes(kept)
        works = [partial(_drawn, view, target, camera, partial(view.seek, time)) for time in moments]
        name = f"{'every frame' if every == 1 else f'one frame in {every}'}, {pixels:g} px"
        ways.append(_Way("keyframes", name, view, works, kept.n_bytes / 1e6, baking.median))
    truth = [work() for work in show]
    times_taken = interleaved_times([work for way in ways for work in way.works], repeats)
    for way, taken in zip(ways, times_taken.reshape(len(ways), -1), strict=True):
        errors = np.stack([255 * np.abs(work() - true) for work, true in zip(way.works, truth, strict=True)])
        row = Row.of(way.group, way.setting, errors, Laps.of(taken))
        yield replace(row, megabytes=way.megabytes, baking=way.baking)
        way.view.release()


@dataclass(frozen=True)
class _Way:
    """To have the model at each of some moments; the last two as in a Row."""

    group: str
    setting: str
    view: SplatView
    works: Sequence[Callable[[], NDArray[np.float64]]]
    megabytes: float | None = None
    baking: float | None = None


def _upload(view: SplatView, model: DynamicGaussians, time: float) -> None:
    view.upload(model.at(time))


def _drawn(
    view: SplatView, target: moderngl.Framebuffer, camera: Camera, prepare: Callable[[], None]
) -> NDArray[np.float64]:
    prepare()
    view.draw(camera, target)
    return read_image(target).astype(np.float64)
