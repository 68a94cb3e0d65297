"""Milliseconds a frame of OpenGL and of the numba rasteriser, split into their parts, over splats and sizes.

python -m tests.benchmarks.draw_speed [SPLATS ...]

The scene is that of renderer.measuring.scattered. sort: depths and order; upload: the order to the driver;
draw: all splats into a target of half floats on a card, of floats on a software driver; resolve: that over
the background. "whole": a frame after the camera moved. numba: from the splats to the picture, all threads.
Medians; quarter: half of the distance between the quartiles of the whole.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import moderngl
import numpy as np
from numba import get_num_threads

from renderer.camera import Camera
from renderer.draw.context import is_software, renderer_name, standalone_context
from renderer.draw.keyframes import Keyframes
from renderer.draw.sorting import depth_order
from renderer.draw.splat_view import SplatView
from renderer.measuring.scattered import scattered
from renderer.rasterize.cpu import BLACK, Rasterizer
from renderer.splats import Splats

COUNTS = (10_000, 30_000, 100_000, 500_000)
SIZES = ((640, 512), (1280, 1024))
SECONDS = 4.0
"""Of repeating a measurement, about."""
LEAST, MOST = 3, 31
HEAD = (
    "    size   splats     sort   upload     draw  resolve    whole  quarter   frames/s    numba   frames/s"
)


def main(counts: tuple[int, ...]) -> None:
    context = standalone_context()
    kind = "software, floats" if is_software(context) else "half floats"
    print(f"OpenGL: {renderer_name(context)} ({kind}); numba: {get_num_threads()} threads; ms\n{HEAD}")
    for width, height in SIZES:
        for count in counts:
            splats, camera = scattered(width, height, count)
            sort, upload, draw, resolve, whole, quarter = opengl(context, splats, camera)
            numba = median(lambda s=splats, c=camera: rasterize(s, c))[0]  # type: ignore[misc]
            print(
                f"{width:4}x{height:<4}{count:8}{sort:9.2f}{upload:9.2f}{draw:9.2f}{resolve:9.2f}{whole:9.2f}"
                f"{quarter:9.2f}{1000 / whole:11.1f}{numba:9.2f}{1000 / numba:11.1f}",
                flush=True,
            )


def opengl(context: moderngl.Context, splats: Splats, camera: Camera) -> tuple[float, ...]:
    """sort, upload, draw, resolve, whole, quarter in milliseconds."""
    keyframes, axis = Keyframes(splats), camera.camera_from_world[2]
    view, empty = SplatView(context), SplatView(context)
    target = context.simple_framebuffer((camera.width, camera.height), 4)
    view.upload(splats)
    order = np.arange(len(splats), dtype=np.uint32)
    buffer = context.buffer(reserve=order.nbytes, dynamic=True)

    def sort() -> None:
        depths = keyframes.depths(axis, 0.0)
        visible = np.flatnonzero((depths > 0.01) & keyframes.drawable).astype(np.uint32)
        visible[depth_order(depths[visible], "float32")][::-1].copy()

    def upload() -> None:
        buffer.orphan()
        buffer.write(order)

    def moved() -> None:
        view.forget_order()
        view.draw(camera, target)
        context.finish()

    def still() -> None:
        view.draw(camera, target)
        context.finish()

    def nothing() -> None:
        empty.draw(camera, target)
        context.finish()

    moved()
    (whole, quarter), resolve = median(moved), median(nothing)[0]
    parts = (median(sort)[0], median(upload)[0], median(still)[0] - resolve, resolve)
    for item in (view, empty, target, buffer):
        item.release()
    return (*parts, whole, quarter)


def rasterize(splats: Splats, camera: Camera) -> None:
    rasterizer = Rasterizer(camera.width, camera.height)
    rasterizer.forward(splats, camera)
    rasterizer.rendered(camera.width, camera.height, BLACK)


def median(work: Callable[[], None]) -> tuple[float, float]:
    """Milliseconds, and half of the distance between their quartiles, after one that does not count."""
    work()
    taken: list[float] = []
    while len(taken) < LEAST or (sum(taken) < SECONDS and len(taken) < MOST):
        began = time.perf_counter()
        work()
        taken.append(time.perf_counter() - began)
    low, middle, high = 1000 * np.percentile(taken, (25, 50, 75))
    return float(middle), float(high - low) / 2


if __name__ == "__main__":
    main(tuple(int(text) for text in sys.argv[1:]) or COUNTS)
