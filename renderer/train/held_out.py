"""Frames that training does not see: some measured while it goes on, at a bounded share of its time, and all
of them at its end."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from time import perf_counter

import numpy as np

from renderer.clip import Clip, Frame
from renderer.evenly import evenly
from renderer.frame_gains import exposed
from renderer.gaussians import DynamicGaussians
from renderer.metrics import depth_rmse, psnr
from renderer.near_plane import NEAR_SHARE
from renderer.rasterize.cpu import render
from renderer.splats import RenderMode
from renderer.train.events import Evaluated

MOST = 4
"""Frames that are measured now and then; they stay in memory."""
SHARE = 0.03
"""Of the time of training that measuring may take."""
FIRST_SECONDS = 2.0
"""Of training before it is measured at all."""


class HeldOut:
    """`size` is the scene size in the clip's unit."""

    def __init__(self, clip: Clip, indices: Sequence[int], size: float, mode: RenderMode = "default") -> None:
        self._clip, self._size, self._mode = clip, size, mode
        self._indices = tuple(evenly(indices, MOST))
        self._frames: tuple[Frame, ...] = ()
        self._next = FIRST_SECONDS

    def is_due(self, seconds: float) -> bool:
        """After so many seconds of training."""
        return bool(self._indices) and seconds >= self._next

    def measure(self, gaussians: DynamicGaussians, iteration: int, seconds: float) -> Evaluated:
        """The model as it stands; the next time is when this one is a small share of what was trained."""
        began = perf_counter()
        if not self._frames:
            self._frames = tuple(self._clip.read_frame(index) for index in self._indices)
        event = evaluated(gaussians, self._frames, iteration, self._size, self._mode)
        self._next = seconds + max((perf_counter() - began) / SHARE, FIRST_SECONDS)
        return event


def evaluated(
    gaussians: DynamicGaussians,
    frames: Iterable[Frame],
    iteration: int,
    size: float,
    mode: RenderMode = "default",
) -> Evaluated:
    """Means over the frames of which something is evaluated; a depth error where some frame has a measured
    depth that the model covers. The model is shown in the exposure of each frame, see `Frame.gain`."""
    quality, errors = [], []
    for frame in frames:
        drawn = render(gaussians.at(frame.time), frame.camera, near=NEAR_SHARE * size, mode=mode)
        shown = exposed(drawn.bytes, frame.gain) / 255.0
        quality.append(psnr(shown, frame.image / 255.0, frame.evaluation_mask))
        if frame.measured_depth is not None:
            errors.append(depth_rmse(drawn.depth, frame.measured_depth, frame.evaluation_mask))
    known, seen = ([one for one in found if not math.isnan(one)] for found in (errors, quality))
    mean = float(np.mean(seen)) if seen else math.nan
    return Evaluated(iteration, mean, float(np.mean(known)) if known else None)
