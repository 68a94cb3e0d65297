"""The windows that a long clip is cut into, each with Gaussians and curves of its own."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import Final

import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.clip import Clip
from renderer.listing import count
from renderer.train.config import TrainConfig
from renderer.train.events import Omission

OVERLAP: Final = 16
"""Frames that two windows share, in which one fades into the next."""
ALIGNED: Final = 8
"""Windows begin at multiples of this, so that the same frames are held out as of the whole clip."""
SHORTEST: Final = 3 * OVERLAP
"""Frames of a window: it overlaps none but its neighbours."""
UNCUT: Final = 2 * SHORTEST - OVERLAP - 1
"""Frames of the longest clip that two windows do not fit in."""
LONGEST: Final = 400
"""Frames of a window where nobody says."""
MOST_VIEWS: Final = 1.0
"""That the camera of a window may see beside its first: twice the tissue for as many Gaussians."""
FEWEST: Final = 8
"""Frames of a window that are trained on or measured: while its view was covered, there are none."""
_GRID: Final = 32
"""Points across and down a view that tell what share of it another one shows."""
_MUCH: Final = 0.25
"""New share of a view after which others are held against it."""


@dataclass(frozen=True)
class Window:
    """Frames of a clip, both included, counted from 0."""

    first: int
    last: int

    def __len__(self) -> int:
        return self.last - self.first + 1

    def of(self, clip: Clip) -> Clip:
        """As a clip of its own, numbered and timed anew; the clip itself where that is all of it."""
        return clip if len(self) == len(clip) else clip.between(self.first, self.last)

    def inside(self, indices: Sequence[int]) -> tuple[int, ...]:
        """Those of a clip's frames that are in it, counted from its first."""
        return tuple(index - self.first for index in indices if self.first <= index <= self.last)


def windows_of(clip: Clip, config: TrainConfig) -> tuple[Window, ...]:
    """In the order of time, of about as many frames as it says, or with as much to show each; a single one
    where the clip is short and its camera goes nowhere. Raises ClipError: the first frame cannot be read."""
    if config.window_frames is not None:
        found = cut(np.full(len(clip), 1 / config.window_frames))
    else:
        found = cut(1 / LONGEST + new_views(clip) / MOST_VIEWS)
    return _seen(found, clip.passed_over)


def cut(shares: NDArray[np.float64]) -> tuple[Window, ...]:
    """Frames in windows of nearly equal parts, each about a whole one: `shares` (N,) says what part of one
    each frame is. None is shorter than SHORTEST, unless the clip is."""
    count, total = len(shares), float(shares.sum())
    shared = min(OVERLAP * total / count, 0.5)
    step = SHORTEST - OVERLAP
    number = min(ceil((total - shared) / (1 - shared) - 1e-9), (count - OVERLAP) // step)
    if number <= 1:
        return (Window(0, count - 1),)
    before = np.concatenate([[0.0], np.cumsum(shares[:-OVERLAP])])
    starts = [0]
    for place in range(1, number):
        wanted = int(np.searchsorted(before, before[-1] * place / number))
        start = max(ALIGNED * (wanted // ALIGNED), starts[-1] + step)
        if start + SHORTEST <= count:
            starts.append(start)
    ends = [start + OVERLAP for start in starts[1:]]
    return tuple(Window(first, end - 1) for first, end in zip(starts, [*ends, count], strict=True))


def _seen(windows: Sequence[Window], passed_over: Collection[int]) -> tuple[Window, ...]:
    """The same; one of which too few frames count goes on the one before it, and the first on the next."""

    def counted(window: Window) -> int:
        return len(window) - sum(window.first <= at <= window.last for at in passed_over)

    found: list[Window] = []
    for window in windows:
        if found and min(counted(found[-1]), counted(window)) < FEWEST:
            found[-1] = Window(found[-1].first, window.last)
        else:
            found.append(window)
    return tuple(found)


def new_views(clip: Clip) -> NDArray[np.float64]:
    """(N,) share of each frame's view that is new, at the distance of the tissue: more than frames before
    had of what the last one with much that was new did not show. Reads a frame where the camera moves."""
    shares = np.zeros(len(clip))
    if clip.camera_is_fixed:
        return shares
    distance, key, told = _distance(clip), clip.cameras[0], 0.0
    for index, camera in enumerate(clip.cameras):
        new = 1 - _shown(camera, key, distance)
        shares[index] = max(new - told, 0.0)
        told = max(new, told)
        if new > _MUCH:
            key, told = camera, 0.0
    return shares


def _distance(clip: Clip) -> float:
    """Median depth of what the first frame for training shows; of sparse points where it has no depth."""
    if clip.points is not None:
        _, depths = clip.cameras[0].project(clip.points.positions)
        seen = depths[depths > 0]
    else:
        frame = clip.read_frame(clip.train_indices[0])
        seen = np.zeros(0) if frame.depth is None else frame.depth[frame.depth_mask].astype(np.float64)
    return float(np.median(seen)) if len(seen) else 1.0


def _shown(camera: Camera, other: Camera, distance: float) -> float:
    """Share of the view of `camera`, at a distance along its axis, that is in the view of the other one."""
    small = camera.resized(_GRID, _GRID)
    points = small.unproject(np.full((_GRID, _GRID), distance)).reshape(-1, 3)
    pixels, depths = other.project(points)
    inside = ((pixels >= 0) & (pixels <= [other.width, other.height])).all(axis=1) & (depths > 0)
    return float(inside.mean())


def cut_notice(windows: Sequence[Window]) -> str:
    """What is said of a clip in several windows."""
    longest = max(map(len, windows))
    return (
        f"the clip is reconstructed in {len(windows)} windows of up to {longest} frames, each with Gaussians "
        f"of its own; neighbours share {OVERLAP} frames, in which one fades into the next"
    )


def left_out(windows: Sequence[Window], config: TrainConfig) -> tuple[Omission, ...]:
    """Other windows, where one is enough for the clip."""
    if len(windows) > 1:
        return ()
    longest = max(config.window_frames or LONGEST, UNCUT)
    limit = count(longest, "frame")
    if config.window_frames is None:
        limit += f" or {count(round(MOST_VIEWS), 'view')} beside the first"
    why = f"the clip has {count(len(windows[0]), 'frame')}, and windows are for more than {limit}"
    return (Omission("windows", why, "Gaussians and curves for each window"),)


def in_words(omitted: Sequence[Sequence[Omission]]) -> tuple[Omission, ...]:
    """What each of the windows does without, told once: as of the first that does."""
    merged: dict[str, Omission] = {}
    for number, of_window in enumerate(omitted, start=1):
        for one in of_window:
            merged.setdefault(one.what, replace(one, why=f"{one.why} (window {number})"))
    return tuple(merged.values())
