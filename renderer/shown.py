"""Which Gaussians of a model at least one frame of its clip shows, by where their centres are.

One whose centre lies behind tissue in all frames has its place and size from the rim of it that shows
beside the tissue in front: seen from elsewhere it is a blot that nothing vouches for.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import cv2
import numpy as np

from renderer.camera import BoolArray, Camera
from renderer.evenly import evenly
from renderer.gaussians import DynamicGaussians
from renderer.rasterize.crossings import REACH
from renderer.splats import Float32Array, RenderMode, Splats

FRAMES = 33
"""Evenly spread, that are looked at."""
LONGER_SIDE = 640
"""Pixels of the image in which depths are compared, at most."""
BEHIND = 0.03
"""Of its own depth, by which a centre may lie behind the tissue that is seen there: Gaussians overlap along
the line of sight, and those just behind fill the gaps of those in front. Chosen by eye on the clip
`pulling_soft_tissues`: 3 % takes the blots, 5 % leaves a third of them, 2 % opens gaps."""
SOLID = 0.5
"""Opacity of what hides something."""


def looks(
    model: DynamicGaussians, cameras: Sequence[Camera], near: float, mode: RenderMode
) -> Iterator[BoolArray]:
    """(N,) True: the centre is in view of one of the cameras, one a frame, and in front of what it sees there
    or hardly behind. After each frame that is looked at; the last one counts. `near` in scene units."""
    found: BoolArray = np.zeros(len(model), bool)
    for frame in evenly(range(len(cameras)), FRAMES):
        camera = cameras[frame]
        smaller = min(1.0, LONGER_SIDE / max(camera.width, camera.height))
        size = (max(1, round(smaller * camera.width)), max(1, round(smaller * camera.height)))
        found |= _shown(model.at(frame / len(cameras)), camera.resized(*size), near, mode)
        yield found


def _shown(splats: Splats, camera: Camera, near: float, mode: RenderMode) -> BoolArray:
    depth = _farthest(splats, camera, near, mode)
    pixels, depths = camera.project(splats.means.astype(np.float64))
    # One that reaches into the image is cut off at its side, or seen beside it.
    reach = REACH * camera.fx * np.abs(splats.scales).max(axis=1) / np.maximum(depths, near)
    size = np.array([camera.width, camera.height])
    reaches = ((pixels > -reach[:, None]) & (pixels < size + reach[:, None])).all(axis=1) & (depths > near)
    column, row = np.clip(np.nan_to_num(pixels), 0, size - 1).astype(np.int64).T
    found: BoolArray = reaches & (depths * (1 - BEHIND) < depth[row, column])
    return found


def _farthest(splats: Splats, camera: Camera, near: float, mode: RenderMode) -> Float32Array:
    """(H, W) depth of the tissue, of a pixel and its neighbours the largest; infinite where there is none."""
    # Its kernels take seconds to import on a first start; the window must not wait for them.
    from renderer.rasterize.cpu import render

    drawn = render(splats, camera, near=near, mode=mode)
    depth = np.where(drawn.alpha > SOLID, drawn.depth, np.float32(np.inf))
    return np.asarray(cv2.dilate(depth, np.ones((3, 3), np.uint8)), np.float32)
