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
from dataclasses import dataclass
from typing import Self

import numpy as np

from renderer.camera import Camera, FloatArray
from renderer.clip import Frame
from renderer.deformation.nodes import attach
from renderer.deformation.spline import spline_taps
from renderer.splats import Float32Array
from renderer.train.curve_fit import CurveFit, Seen
from renderer.train.flow_tracks import REACH, Tracks, View, tracks_from, view_of

APART = 16
"""Frames between those from which tracks start."""
FEWEST, MOST = 4, 50
"""Tracks about a node of which a median is taken, and more than which count no more."""
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

    @classmethod
    def of(cls, frames: Sequence[Frame], camera: Camera, grid: tuple[int, int], n_controls: int) -> Self:
        """From frames in the order of time; zero where they have no depth."""
        seen = tuple(_seen(frames, camera, grid))
        fit = CurveFit.of([frame.time for frame in frames], n_controls, grid, seen)
        return cls(camera, grid, fit.solved().astype(np.float32))

    def at_rest(self, points: FloatArray, time: float) -> Float32Array:
        """(N, 3) where points that are seen at `time` rest: there, the motion takes them to `points`."""
        first, weights = spline_taps(time, self.controls.shape[1])
        nodes = np.einsum("k,mkc->mc", weights, self.controls[:, first : first + 4])
        resting = points.astype(np.float32)
        for _ in range(SETTLING):
            indices, shares = attach(resting, self.camera, self.grid)
            resting = (points - np.einsum("nk,nkc->nc", shares, nodes[indices])).astype(np.float32)
        return resting


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
