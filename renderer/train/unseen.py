"""Gaussians that training never saw: nothing can be said of them, so that they are left out at the end."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from renderer.gaussians import DynamicGaussians
from renderer.rasterize.cpu import Rasterizer
from renderer.splats import RenderMode
from renderer.train.events import Omission
from renderer.train.frames import TrainFrame


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
