"""Tissue that moves out of sight fades on the way: beside the frame's edge, or under what is burned into it.

Where no frame of a fixed camera shows tissue, training asks for nothing to be there. A Gaussian that is seen
at other times cannot follow: without it, what it shows then would be lost. It stays as a speck beyond the
edge. So each one whose blending weight lies beyond what any frame shows gets a curve of its opacity logit,
fitted to the training frames: less from FADES[0] of its weight on, nothing from FADES[1] on.

So does what hangs in shreds there, torn from tissue that moved elsewhere while a tool hid both: what is
narrower than SHRED between clear pixels, and not beside what is wider.

Both were chosen on training frames that were held out: of pulling (1500 steps, seed 0) 71 pixels of specks a
frame without, 1.2 with (0.1, 0.4) and (0.3, 0.7), 1.5 with (0.5, 0.9), and seldom seen tissue 39.59, 39.52,
39.61 and 39.60 dB; of the phantom 24, 14, 17 and 17 pixels; PSNR stays within 0.002 dB. Leaving out what has
more than half of its weight beyond the edge (176 Gaussians) loses 0.2 dB, 3 of seldom seen tissue.

The curve is fitted twice, the second time by what the first one leaves: a few frames beyond the edge between
many within it would count too little. Of pulling (2000 steps, seed 0) it takes 18 pixels of specks of two
training frames; of training frames held out (3000 steps) 39.356 and 39.355 dB, 39.56 and 39.54 of what is
seldom seen.

What lies all in the margin of an edge, out of sight itself, hangs out of the edge as a knob. So what has a
share of OUTSIDE beyond what frames show fades, too. On eight fitted frames of pulling (2000 steps, seed 1) 20
pixels of specks without it, 5 with, 3 with (0.75, 0.95), which loses 0.14 dB of what is seldom seen of
mesentery (3000 steps, on frames held out); from 0.85 on none is lost. A steeper one lets curves swing.

What fades uncovers what lay behind, which hardly showed and was kept; so all is looked at again, for knobs.
The least that is left counts, not what is left of that. On training frames of mesentery that were held out
(400 steps, seed 0), without and with it: 36.305 dB each, 39.568 and 39.565 of what is seldom seen; with FADES
once more 36.302 and 39.562, and of pulling (700 steps) 38.327 each and 38.07 each, without and with.

Where frames are missing, as those held out, moments between two are looked at as well. Without, at one of 16
such moments of pulling (1000 steps, seed 0) a speck of 3 pixels stays, with them none.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import reduce
from itertools import pairwise
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.clip import BoolImage
from renderer.deformation.spline import spline_taps
from renderer.deformation.spline_motion import SplineMotion
from renderer.gaussians import DynamicGaussians
from renderer.rasterize.binning import TILE
from renderer.rasterize.cpu import BLACK, Rasterizer
from renderer.raw_gaussians import logits, sigmoid
from renderer.splats import RenderMode
from renderer.train.frames import TrainFrame, tissue_tiles, unseen_beyond

FADES: Final = (0.3, 0.7)
"""Shares of the blending weight of a Gaussian that lie where no frame shows tissue within a margin."""
OUTSIDE: Final = (0.87, 1.0)
"""The same, with the margin at the edge of what is seen: almost nothing shows of what lies so."""
ROUNDS: Final = 2
"""Times that it is looked at what lies beyond: what fades uncovers what lay behind it."""
WIDE: Final = 1.5
"""Times the closest two times, by which others are a gap that frames are missing from."""
LEAST: Final = 0.01
"""Of the opacity that is left: a curve to nothing would swing between frames."""
WITHIN: Final = (1e-6, 1 - 1e-6)
"""Opacities whose logits are reckoned with."""
CLOSE: Final = 1e-3
"""Logits that differ by less are alike."""
TRACE: Final = np.float32(0.1)
"""Blending weight, in pixels, that is too little to tell by."""
RING: Final = 2
"""Tiles beside those in which there is nothing to see; no other is drawn."""
STIFFNESS: Final = 1e-4
"""Of curves where no frame holds them; a frame holds them by up to 0.25."""
SOLID: Final = 0.5
"""Alpha of tissue, against what is clear."""
SHRED: Final = 9
"""Pixels: hidden tissue that is narrower, between what is clear, hangs on nothing."""
BATCH: Final = 256
"""Curves that are fitted at once."""


def faded_out_of_sight(
    gaussians: DynamicGaussians,
    frames: Sequence[TrainFrame],
    unseen: BoolImage,
    near: float,
    mode: RenderMode = "default",
) -> DynamicGaussians:
    """The model with curves of opacity for what leaves the part of the image that is ever seen.

    Args:
        frames: all of one size, of one fixed camera.
        unseen: (H, W), True where no frame shows tissue, see `renderer.train.frames.unseen_beyond`.
    """
    motion = gaussians.motion
    if not (isinstance(motion, SplineMotion) and unseen.any()):
        return gaussians
    moments = _moments(frames)
    times = [time for time, _ in moments]
    masks = unseen, ~reduce(np.logical_or, (visible for _, visible in moments))
    left, faded = np.ones((len(times), len(gaussians))), gaussians
    for once_more in range(ROUNDS):
        beyond = np.stack(list(_shares_beyond(faded, moments, frames[0].camera, masks, near, mode)))
        found = _kept(beyond[:, 1], OUTSIDE)
        if not once_more:
            found = np.minimum(found, _kept(beyond[:, 0], FADES))
        if (found >= left).all():
            break
        left = np.minimum(left, found)
        faded = _with_left(gaussians, motion, left, times)
    return faded


def _with_left(
    gaussians: DynamicGaussians, motion: SplineMotion, left: NDArray[np.float64], times: Sequence[float]
) -> DynamicGaussians:
    """The model with curves by which so much (T, N) of its opacities is left at T times."""
    strays = np.flatnonzero(left.min(axis=0) < 1)
    leaving = gaussians.rows(strays)
    opacities = np.stack([leaving.at(time).opacities for time in times]).clip(*WITHIN)
    wanted = (left[:, strays] * opacities).clip(*WITHIN)
    # What a step of the logit does to the opacity: of next to nothing left, little matters.
    weights = wanted * (1 - wanted)
    goal, begun = logits(wanted), logits(opacities)
    curves = fitted_curves(goal - begun, weights, times, motion.n_controls)
    # Where it then falls short of a low goal, a step of the logit does much.
    missed = begun + _values(curves, times) - goal
    rise = np.abs(sigmoid(goal + missed) - wanted) / np.maximum(np.abs(missed), CLOSE)
    weights = np.where(np.abs(missed) < CLOSE, weights, rise)
    curves = fitted_curves(goal - begun, weights, times, motion.n_controls)
    controls = opacity_curves(motion, len(gaussians))
    controls[strays, :, 0] += curves.astype(np.float32)
    return replace(gaussians, motion=replace(motion, opacity_controls=controls))


def _moments(frames: Sequence[TrainFrame]) -> list[tuple[float, BoolImage]]:
    """Times, and what tissue (H, W) is visible: of the frames, and halfway between two of them that are
    further apart than the closest ones, where what either shows is."""
    shown = [(frame.time, frame.tissue) for frame in frames]
    pairs = list(pairwise(shown))
    least = min((after[0] - before[0] for before, after in pairs), default=0.0)
    far = [(before, after) for before, after in pairs if after[0] - before[0] > WIDE * least]
    return shown + [((before[0] + after[0]) / 2, before[1] | after[1]) for before, after in far]


def _shares_beyond(
    gaussians: DynamicGaussians,
    moments: Sequence[tuple[float, BoolImage]],
    camera: Camera,
    masks: tuple[BoolImage, BoolImage],
    near: float,
    mode: RenderMode,
) -> Iterator[NDArray[np.float32]]:
    """(2, N) at each time: shares of the blending weight that lie beyond the margin of what any frame shows,
    or in shreds, and beyond what any shows.

    Args:
        masks: (H, W) True beyond that margin, and without it.
    """
    unseen, outside = masks
    ring = np.ones((2 * RING + 1, 2 * RING + 1))
    edge = cv2.dilate(tissue_tiles(unseen).astype(np.uint8), ring) > 0
    drawn = edge.repeat(TILE, axis=0).repeat(TILE, axis=1)[: camera.height, : camera.width]
    rasterizer = Rasterizer(camera.width, camera.height)
    for time, visible in moments:
        rasterizer.forward(gaussians.at(time), camera, near, edge, mode)
        alpha = rasterizer.rendered(camera.width, camera.height, BLACK).alpha
        out = unseen | _shreds((alpha > SOLID) | visible | ~drawn) & ~visible
        within, beyond, never = rasterizer.blending_weights(~out, out, outside)
        whole = within + beyond + TRACE
        yield np.stack((beyond, never)) / whole


def _shreds(solid: BoolImage) -> BoolImage:
    """(H, W) True beyond all that holds a disc of SHRED in what is solid (H, W); the image's border is no
    edge."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (SHRED, SHRED))
    return unseen_beyond(cv2.morphologyEx(solid.astype(np.uint8), cv2.MORPH_OPEN, disc) > 0)


def _kept(shares: NDArray[np.float32], fades: tuple[float, float]) -> NDArray[np.float64]:
    """Share of the opacity that is left, by a smoothstep."""
    t = np.clip((shares.astype(np.float64) - fades[0]) / (fades[1] - fades[0]), 0, 1)
    return LEAST + (1 - LEAST) * (1 - t * t * (3 - 2 * t))


def opacity_curves(motion: SplineMotion, count: int) -> NDArray[np.float32]:
    """(N, K, 1) a copy of those of `count` Gaussians, 0 where they have none."""
    curves = motion.opacity_controls
    return curves.copy() if len(curves) else np.zeros((count, motion.n_controls, 1), np.float32)


def _values(curves: NDArray[np.float64], times: Sequence[float]) -> NDArray[np.float64]:
    """(T, S) of the splines of (S, K) control values."""
    values = np.empty((len(times), len(curves)))
    for row, time in zip(values, times, strict=True):
        first, taps = spline_taps(time, curves.shape[1])
        row[:] = curves[:, first : first + len(taps)] @ taps
    return values


def fitted_curves(
    values: NDArray[np.float32], weights: NDArray[np.float64], times: Sequence[float], count: int
) -> NDArray[np.float64]:
    """(S, count) control values of splines for (T, S) values at T times, by weighted least squares."""
    steps = np.diff(np.eye(count), axis=0)
    curves = np.empty((values.shape[1], count))
    for begin in range(0, len(curves), BATCH):
        part = slice(begin, begin + BATCH)
        normal = np.tile(STIFFNESS * steps.T @ steps, (len(curves[part]), 1, 1))
        right = np.zeros((len(normal), count))
        for time, value, weight in zip(times, values[:, part], weights[:, part], strict=True):
            first, taps = spline_taps(time, count)
            near = slice(first, first + len(taps))
            normal[:, near, near] += weight[:, None, None] * np.outer(taps, taps)
            right[:, near] += (weight * value)[:, None] * taps
        curves[part] = np.linalg.solve(normal, right[..., None])[..., 0]
    return curves
