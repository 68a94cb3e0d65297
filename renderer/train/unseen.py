"""Gaussians that training never saw, or hardly: nothing can be said of them, so that they are left out at the
end.

Beyond a round field of view nothing is supervised, and where the camera moves no pixel is beyond it for good:
there one Gaussian of the dark depth can grow to many times the size of the others and lie over the surround
as a haze, of which each frame shows an edge alone. So those are left out of which every frame shows less
than LEAST. Chosen on training frames of `sinus_moving_camera` (3000 steps, seed 0), from 0.5, 0.4, 0.3, 0.2
and 0.13: pixels of haze a frame (alpha from 0.05 to 0.9, more than 12 pixels beyond the field) 125,307
without, 55,858, 56,186, 55,510, 57,117 and 56,809 with it, PSNR of the field 37.98, then 37.83, 37.87, 37.90,
37.92 and 37.92 dB, by 255, 186, 115, 59 and 33 Gaussians of 30,000. Where the camera is fixed, what lies
beyond fades instead, see fading.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from renderer.gaussians import DynamicGaussians
from renderer.rasterize.cpu import Rasterizer
from renderer.splats import RenderMode
from renderer.train.events import Omission
from renderer.train.frames import TrainFrame

LEAST: Final = 0.13
"""Share of the blending weight of a Gaussian that supervised pixels of some frame show."""
TRACE: Final = np.float32(0.1)
"""Blending weight, in pixels, that is too little to tell by: what other tissue hides stays."""


def without_unseen(
    gaussians: DynamicGaussians, frames: Sequence[TrainFrame], near: float, mode: RenderMode = "default"
) -> tuple[DynamicGaussians, tuple[Omission, ...]]:
    """The Gaussians that reach a tile with tissue in some frame, and what was left out.

    Tissue looks exactly the same without the others in every one of the frames, which are of one size.
    """
    seen = seen_in(gaussians, frames, near, mode)
    lost = len(seen) - int(np.count_nonzero(seen))
    if lost == 0:
        return gaussians, ()
    saves = f"{lost} of {len(seen)} Gaussians"
    omission = Omission("unseen Gaussians", "no training frame shows them", saves, "unseen")
    return gaussians.rows(np.flatnonzero(seen)), (omission,)


def seen_in(
    gaussians: DynamicGaussians, frames: Sequence[TrainFrame], near: float, mode: RenderMode = "default"
) -> NDArray[np.bool_]:
    """(N,) True: reaches a tile with tissue in some frame."""
    seen = np.zeros(len(gaussians), bool)
    rasterizer = Rasterizer(frames[0].camera.width, frames[0].camera.height)
    for frame in frames:
        rasterizer.forward(gaussians.at(frame.time), frame.camera, near, frame.tile_wanted, mode)
        seen |= rasterizer.reaches_wanted
    return seen


def without_overhang(
    gaussians: DynamicGaussians, frames: Sequence[TrainFrame], near: float, mode: RenderMode = "default"
) -> tuple[DynamicGaussians, tuple[Omission, ...]]:
    """The Gaussians of which some of the frames, of one size, shows LEAST or more, and what was left out."""
    kept = shares_shown(gaussians, frames, near, mode) >= LEAST
    lost = len(kept) - int(np.count_nonzero(kept))
    if lost == 0:
        return gaussians, ()
    saves, why = f"{lost} of {len(kept)} Gaussians", f"no frame shows {100 * LEAST:.0f} % of them"
    omission = Omission("Gaussians beyond the edge", why, saves, "unseen")
    return gaussians.rows(np.flatnonzero(kept)), (omission,)


def shares_shown(
    gaussians: DynamicGaussians, frames: Sequence[TrainFrame], near: float, mode: RenderMode = "default"
) -> NDArray[np.float32]:
    """(N,) share of the blending weight that supervised pixels have, in the frame where that is largest; 1
    where no frame tells."""
    shown = np.zeros(len(gaussians), np.float32)
    rasterizer = Rasterizer(frames[0].camera.width, frames[0].camera.height)
    everywhere = np.ones(frames[0].tissue.shape, bool)
    for frame in frames:
        rasterizer.forward(gaussians.at(frame.time), frame.camera, near, mode=mode)
        within, whole = rasterizer.blending_weights(frame.tissue, everywhere)
        shown = np.maximum(shown, (within + TRACE) / (whole + TRACE))
    return shown
