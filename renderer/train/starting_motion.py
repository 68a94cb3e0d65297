"""Curves of the motion nodes before the first step, from tracks through the clip.

Without them every Gaussian begins where its frame shows it, so that one piece of tissue lies in as many
places as it moves to, and training has to bring them together. Held out of training, without and with:

pulling, 1000 steps: 38.05 -> 38.47 dB, 3.01 -> 2.64 mm of depth error; 3000 steps: 38.75 ->
38.95 dB. Mesentery, 3000 steps: 32.9 -> 34.3 dB. Phantoms, 600 steps: before a fixed camera 35.2 -> 38.5 dB,
0.43 -> 0.08 mm; before a moving one 34.1 -> 36.1 dB, 0.47 -> 0.08 mm. With depth guessed from brightness,
300 steps: pulling 35.0 -> 35.4 dB, laparoscopy 25.6 -> 26.8 dB.

NEIGHBOURS of 0.1, STEADY of 0.01, 30 columns of nodes and half the rate of motion change less
than the seed does.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final, Self

import numpy as np

from renderer.camera import BoolArray, Camera, FloatArray
from renderer.clip import Frame
from renderer.deformation.nodes import attach, node_grid
from renderer.deformation.spline import (
    FEWEST_PER_CONTROL,
    FRAMES_PER_CONTROL,
    controls_for,
    most_controls,
    spline_taps,
)
from renderer.splats import Float32Array
from renderer.train.curve_fit import ROUGH, CurveFit, Seen
from renderer.train.flow_tracks import REACH, Tracks, View, tracks_from, view_of

APART = 16
"""Frames between those from which tracks start."""
FEWEST, MOST = 4, 50
"""Tracks about a node of which a median is taken, and more than which count no more."""
PER_CONTROL: Final = (FRAMES_PER_CONTROL, 3.2, 2.7, FEWEST_PER_CONTROL)
"""Frames for each control value that are tried: with fewer than 2 that are fitted, curves follow noise."""
DENSEST: Final = 2.0
"""To compare with."""
TURNS: Final = 4
"""In which frames are left out while they are."""
TOLERATED: Final = (0.04, 0.2)
"""Share, and pixels, by which fewer control values may miss more than the most do.

Frames held out of training, 1500 steps: pulling, which takes 23 in place of 17 then, and 27 with all its
training frames, has 38.68 dB with 17, 38.87 with 20, 39.10 with 24, 38.96 with 32. Mesentery keeps 9 (33.74
dB; with 12 33.65, with 16 33.28), and so does a phantom its 13 (800 steps, 42.6 dB; with 16 42.5, with 20
41.8)."""
SETTLING = 4
"""Rounds in which the nodes that a point holds on to, and where it rests, come to agree."""


@dataclass(frozen=True, eq=False)
class StartingMotion:
    """How the nodes of a grid over the view of `camera` move."""

    camera: Camera
    grid: tuple[int, int]
    """Columns and rows."""
    controls: Float32Array
    """(M, K, 3) of the nodes' curves; their mean over the clip is about 0."""

    def at_rest(self, points: FloatArray, time: float) -> Float32Array:
        """(N, 3) where points that are seen at `time` rest: there, the motion takes them to `points`."""
        first, weights = spline_taps(time, self.controls.shape[1])
        nodes = np.einsum("k,mkc->mc", weights, self.controls[:, first : first + 4])
        resting = points.astype(np.float32)
        for _ in range(SETTLING):
            indices, shares = attach(resting, self.camera, self.grid)
            resting = (points - np.einsum("nk,nkc->nc", shares, nodes[indices])).astype(np.float32)
        return resting


@dataclass(frozen=True, eq=False)
class Followed:
    """Where tissue about the nodes of a grid was seen to go."""

    camera: Camera
    grid: tuple[int, int]
    times: tuple[float, ...]
    """Of the frames, rising in [0, 1]."""
    pixel: float
    """Length of one on the tissue."""
    seen: tuple[Seen, ...]

    @classmethod
    def of(cls, frames: Sequence[Frame], columns: int) -> Self:
        """Through frames in the order of time, some of which have depth: where none is, nothing is seen."""
        camera, grid = node_view(frames, columns)
        depth = next(median for frame in frames if (median := frame.median_depth) is not None)
        times = tuple(frame.time for frame in frames)
        return cls(camera, grid, times, depth / camera.fx, tuple(_seen(frames, camera, grid)))

    def motion(self, n_controls: int) -> StartingMotion:
        """Curves of so many control values."""
        fit = CurveFit.of(self.times, n_controls, self.grid, self.seen)
        return StartingMotion(self.camera, self.grid, fit.solved().transpose(1, 0, 2).astype(np.float32))

    def controls_for(self, n_frames: int) -> int:
        """How many control values curves need, in a clip of `n_frames`: the fewest with which frames that are
        left out of the fit are as close as with the DENSEST, but for TOLERATED."""
        most = most_controls(n_frames)
        counts = sorted({min(controls_for(n_frames, per_control), most) for per_control in PER_CONTROL})
        if len(counts) == 1:
            return most
        least = self._error(controls_for(n_frames, DENSEST))
        bound = max(least * (1 + TOLERATED[0]), least + TOLERATED[1] * self.pixel)
        return next((count for count in counts[:-1] if self._error(count) <= bound), counts[-1])

    def _error(self, n_controls: int) -> float:
        """Mean distance from the curves to what was seen in frames that are left out of their fit, each frame
        in turn; 0 where nothing was seen."""
        total, weight = 0.0, 0.0
        for turn in range(TURNS):
            left_out = np.arange(len(self.times)) % TURNS == turn
            left_out[[0, -1, *(one.reference for one in self.seen)]] = False
            curves = self._curves_without(left_out, n_controls)
            for one in self.seen:
                judged = np.where(left_out[one.frames, None], one.weights, 0)
                away = np.linalg.norm(curves[one.frames] - curves[one.reference] - one.shifts, axis=2)
                total, weight = total + float((judged * away).sum()), weight + float(judged.sum())
        return total / weight if weight > 0 else 0.0

    def _curves_without(self, left_out: BoolArray, n_controls: int) -> FloatArray:
        """(n, M, 3) at all frames, fitted to the others."""
        fitted = tuple(
            replace(one, weights=np.where(left_out[one.frames, None], 0, one.weights)) for one in self.seen
        )
        fit = CurveFit.of(self.times, n_controls, self.grid, fitted)
        return fit.curves(fit.solved(ROUGH))


def node_view(frames: Sequence[Frame], columns: int) -> tuple[Camera, tuple[int, int]]:
    """The camera of the first frame that has depth, and the grid of nodes over its view."""
    camera = next(frame.camera for frame in frames if frame.depth_mask.any())
    return camera, node_grid(camera, columns)


def _seen(frames: Sequence[Frame], camera: Camera, grid: tuple[int, int]) -> Iterator[Seen]:
    """From every APART-th frame to those within reach; only these are in memory."""
    views: dict[int, View] = {}
    for place in range(min(APART, len(frames)) // 2, len(frames), APART):
        near = range(max(0, place - REACH), min(place + REACH + 1, len(frames)))
        views = {each: views.get(each) or view_of(frames[each]) for each in near}
        found = tracks_from([views[each] for each in near], place - near.start)
        medians = [_about_nodes(tracks, camera, grid) for tracks in found]
        shifts, weights = (np.stack(each) for each in zip(*medians, strict=True))
        yield Seen(place, slice(near.start, near.stop), shifts, weights)


def _about_nodes(tracks: Tracks, camera: Camera, grid: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
    """Median shift (M, 3) of the tracks that start nearest to each node, and its weight (M,) from 0 to 1."""
    columns, rows = grid
    indices, shares = attach(tracks.start, camera, grid)
    nearest = indices[np.arange(len(indices)), shares.argmax(axis=1)]
    count = np.bincount(nearest, minlength=columns * rows)
    enough = count >= FEWEST
    middles = (np.cumsum(count) - count + count // 2)[enough]
    shifts = np.zeros((columns * rows, 3))
    for axis in range(3):
        order = np.lexsort((tracks.shift[:, axis], nearest))
        shifts[enough, axis] = tracks.shift[order[middles], axis]
    return shifts, np.where(enough, np.minimum(count, MOST) / MOST, 0.0)
