"""Gaps that open in tissue while a tool hides it: nothing holds Gaussians together there, and the dark shows.

Copies of the Gaussians beside a gap close it. Each lies in it, just behind the tissue, moves and is coloured
as the one that it is a copy of, and has a curve of opacity by which it is there while the place is hidden
alone: what is visible lets a little light through, and was trained with nothing behind it.

Wide gaps take several: a frame is looked at again until none of its tissue is clear, or ROUNDS times.

Pixels a frame of alpha below COVERED in hidden tissue that is often seen, PSNR and that of what is seldom
seen, on training frames that were held out (seed 0), without, with copies in one round in gaps of up to 9
pixels, and so: pulling (1200 steps) 1092, 276 and 80, 38.876, 38.875 and 38.875 dB, 38.74 each; mesentery
(400) 1088, 286 and 166, 35.06 and 37.33 each; specks and depth stay. There are 364 and 280 copies.
Chosen on pulling: without OFTEN, 0.13 dB of what is seldom seen are lost; with a WEIGHT of 1 and no NEAR_EDGE
besides, 0.01 dB more of all; with copies that are 1.4 times as large, 0.02 dB more. Every frame in place of
one in EVERY closes 3 % more. What stays open lies at the edge of what is often seen, and beside tools.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera, FloatArray
from renderer.clip import BoolImage
from renderer.deformation.spline_motion import SplineMotion
from renderer.depth.filled_depth import filled_depth
from renderer.gaussians import DynamicGaussians
from renderer.rasterize.cpu import BLACK, Rasterizer
from renderer.rasterize.rendered import Rendered
from renderer.raw_gaussians import logits
from renderer.splats import Float32Array, RenderMode, Splats
from renderer.train.fading import LEAST, fitted_curves, opacity_curves
from renderer.train.frames import TrainFrame, tissue_tiles

COVERED: Final = 0.9
"""Alpha below which tissue has a gap."""
WIDEST: Final = 40.0
"""Pixels from a copy to what it is a copy of, at most."""
ROUNDS: Final = 4
"""Times that a frame is looked at: copies leave narrower gaps between them."""
TIE: Final = np.float32(1e-6)
"""Of alpha, by which equally clear pixels differ."""
OFTEN: Final = 0.3
"""Share of the frames that show tissue in a pixel up to which gaps stay: little tells what is there."""
EVERY: Final = 2
"""Frames from one that is looked at to the next."""
APART: Final = 5
"""Side in pixels of the window of which the clearest pixel gets a copy."""
BEHIND: Final = 1.01
"""Times the depth of what it is a copy of."""
SAME_DEPTH: Final = 0.03
"""By which the depth of a Gaussian differs at most from what is drawn beside it."""
THERE, GONE = logits(np.array((0.95, LEAST)))
"""Logits of the opacity of a copy, while its place is hidden and while it is visible."""
NEAR_EDGE: Final = 9
"""Side in pixels of a disc that must be hidden around a copy."""
WEIGHT: Final = 10.0
"""Of frames in which a copy is visible, against others, in the fit of its curve."""


def closed_gaps(
    gaussians: DynamicGaussians, frames: Sequence[TrainFrame], near: float, mode: RenderMode = "default"
) -> DynamicGaussians:
    """The model with copies in the gaps of what frames, all of one size and of one fixed camera, hide."""
    if not isinstance(gaussians.motion, SplineMotion):
        return gaussians
    count, camera = len(gaussians), frames[0].camera
    motion = replace(gaussians.motion, opacity_controls=opacity_curves(gaussians.motion, count))
    closed = replace(gaussians, motion=motion)
    often = np.asarray(sum(frame.tissue.astype(np.float32) for frame in frames) > OFTEN * len(frames))
    rasterizer = Rasterizer(camera.width, camera.height)
    for place in range(0, len(frames), EVERY):
        hidden = often & ~frames[place].tissue
        for _ in range(ROUNDS if hidden.any() else 0):
            splats, before = closed.at(frames[place].time), len(closed)
            rasterizer.forward(splats, camera, near, _reached(hidden), mode)
            drawn = rasterizer.rendered(camera.width, camera.height, BLACK)
            closed = _with_copies(closed, count, splats, camera, drawn, hidden)
            if len(closed) == before:
                break
    return _while_hidden(closed, count, frames, often) if len(closed) > count else gaussians


def _reached(hidden: BoolImage) -> BoolImage:
    """(tile rows, tile columns) of what is hidden, and those beside: edges of gaps are drawn."""
    return cv2.dilate(tissue_tiles(hidden).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0


def _disc(side: int) -> NDArray[np.uint8]:
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side)).astype(np.uint8)


def _clearest(alpha: Float32Array, gap: BoolImage) -> BoolImage:
    """(H, W) True in a gap where it is clearest of the pixels about it; of some that are as clear, at one."""
    rows, columns = np.ogrid[: alpha.shape[0], : alpha.shape[1]]
    order = alpha + TIE * (rows % APART * APART + columns % APART).astype(np.float32)
    return np.asarray(gap & (order <= cv2.erode(order, np.ones((APART, APART), np.uint8))))


def _with_copies(
    gaussians: DynamicGaussians,
    first: int,
    splats: Splats,
    camera: Camera,
    drawn: Rendered,
    hidden: BoolImage,
) -> DynamicGaussians:
    """With copies, in gaps of what is hidden, of the nearest of the `first` Gaussians of the tissue there."""
    covered = drawn.alpha >= COVERED
    surroundings = filled_depth(drawn.depth, covered)
    gap = hidden & ~covered & (surroundings > 0)
    centers, depths = camera.project(splats.means[:first].astype(np.float64))
    parents, depth = np.zeros(covered.shape, np.int64), np.zeros(covered.shape)
    for row, column in np.argwhere(_clearest(drawn.alpha, gap)):
        away = np.hypot(*(centers - (column + 0.5, row + 0.5)).T)
        away[~(np.abs(depths / surroundings[row, column] - 1) < SAME_DEPTH)] = np.inf
        nearest = away.argmin()
        if away[nearest] < WIDEST:
            parents[row, column], depth[row, column] = nearest, BEHIND * depths[nearest]
    found = depth > 0
    chosen, places, count = parents[found], camera.unproject(depth)[found], len(gaussians)
    grown = gaussians.rows(np.concatenate([np.arange(count), chosen]))
    raw, motion = grown.raw, grown.motion
    assert isinstance(motion, SplineMotion)
    raw.means[count:] += (places - splats.means[chosen]).astype(np.float32)
    raw.opacity_logits[count:] = THERE
    motion.opacity_controls[count:] = 0
    return grown


def _while_hidden(
    gaussians: DynamicGaussians, count: int, frames: Sequence[TrainFrame], often: BoolImage
) -> DynamicGaussians:
    """All from `count` on get curves of opacity, to nothing in frames in which they are visible."""
    motion, camera = gaussians.motion, frames[0].camera
    assert isinstance(motion, SplineMotion)
    copies = gaussians.rows(np.arange(count, len(gaussians)))
    shown = []
    for frame in frames:
        apart = cv2.erode((~frame.tissue).astype(np.uint8), _disc(NEAR_EDGE)) > 0
        shown.append(~_at(often & apart, camera.project(copies.at(frame.time).means.astype(np.float64))[0]))
    visible = np.stack(shown)
    steps = np.where(visible, GONE - THERE, np.float32(0))
    times = [frame.time for frame in frames]
    curves = fitted_curves(steps, np.where(visible, WEIGHT, 1.0), times, motion.n_controls)
    motion.opacity_controls[count:, :, 0] = curves
    return gaussians


def _at(mask: BoolImage, centers: FloatArray) -> NDArray[np.bool_]:
    """(N,) of the pixels that positions (N, 2) are in, or of the nearest at the border."""
    columns, rows = np.floor(centers).astype(np.int64).T
    found: NDArray[np.bool_] = mask[rows.clip(0, mask.shape[0] - 1), columns.clip(0, mask.shape[1] - 1)]
    return found
