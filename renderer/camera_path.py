"""A camera that goes smoothly through keyframes of pose, lens and time of the clip.

Each segment is a cubic Hermite curve whose ends have the same velocity as their neighbours', so that motion
has no corners (C1); velocities are finite differences over uneven knots (Catmull-Rom), bounded by the slower
of the two segments, so that the camera stays near its keyframes however uneven their seconds are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Final

import numpy as np

from renderer.budget import budget
from renderer.camera import Camera, FloatArray
from renderer.rotations import conjugate, logarithm, matrix, product, quaternion, turned_hermite

SAME: Final = 1e-9
"""Two poses nearer than this, in radians or in shares of the path's size, are one: there the camera rests."""

LATEST: Final = 1e6
"""Seconds of a keyframe: controls tell hundredths of it apart."""

SOONEST: Final = 1e-6
"""Seconds from one keyframe to the next."""

MOST: Final = 3.0
"""Times the mean velocity of the slower segment at a keyframe: up to here a cubic along a line never leaves
its two ends (F. N. Fritsch, R. E. Carlson, "Monotone piecewise cubic interpolation", SIAM J. Numer. Anal.
17, 1980)."""

TRACK: Final = 24
"""Points of a track from one keyframe to the next."""


@dataclass(frozen=True)
class Keyframe:
    """Where the camera is and what moment it shows, so many seconds after the path's beginning."""

    seconds: float
    time: float
    """Of the clip, in [0, 1]."""
    camera: Camera


@dataclass(frozen=True)
class CameraPath:
    """Keyframes in the order of their seconds.

    A path whose last keyframe sees what its first sees is closed: it goes through that view without a corner.

    Raises:
        ValueError: seconds that do not increase, times outside [0, 1], or numbers that are not finite.
    """

    keyframes: tuple[Keyframe, ...]

    def __post_init__(self) -> None:
        for place, key in enumerate(self.keyframes):
            if not (abs(key.seconds) <= LATEST and 0 <= key.time <= 1):
                wanted = f"finite seconds of at most {LATEST:.0f} and a time in [0, 1]"
                raise ValueError(f"keyframe {place}: expected {wanted}, got {key.seconds}, {key.time}")
        seconds = [key.seconds for key in self.keyframes]
        if seconds:
            budget().require(seconds=seconds[-1] - seconds[0])
        for place, (before, after) in enumerate(pairwise(seconds), start=1):
            if after - before < SOONEST:
                raise ValueError(f"keyframe {place}: expected more than {before} s, got {after} s")

    @property
    def start(self) -> float:
        return self.keyframes[0].seconds if self.keyframes else 0.0

    @property
    def end(self) -> float:
        return self.keyframes[-1].seconds if self.keyframes else 0.0

    def at(self, seconds: float) -> Keyframe:
        """What is seen after so many seconds; before the first keyframe and after the last these stand still.

        The picture has the size of the first keyframe's; other shapes are fitted into it.
        Raises ValueError for a path without keyframes.
        """
        if not self.keyframes:
            raise ValueError("expected at least one keyframe in a camera path, got none")
        seconds = min(max(seconds, self.start), self.end)
        return self._curve.at(seconds)

    @cached_property
    def _curve(self) -> _Curve:
        return _Curve(self.keyframes)

    @cached_property
    def track(self) -> FloatArray:
        """(P, 3) points along its way, so many from one keyframe to the next that it looks smooth."""
        return self._curve.track() if self.keyframes else np.zeros((0, 3))

    def moments(self, per_second: float) -> tuple[Keyframe, ...]:
        """So many views a second, evenly, from the first keyframe on; the last one is the last keyframe's."""
        count = math.ceil((self.end - self.start) * per_second - 1e-9) + 1
        return tuple(self.at(self.start + index / per_second) for index in range(count))


class _Curve:
    """The keyframes as arrays over their seconds, with the velocity at each."""

    def __init__(self, keyframes: tuple[Keyframe, ...]) -> None:
        first = keyframes[0].camera
        self._keyframes = [
            replace(key, camera=key.camera.fitted(first.width, first.height)) for key in keyframes
        ]
        cameras = [key.camera for key in self._keyframes]
        self._size = (first.width, first.height)
        self._seconds = np.array([key.seconds for key in keyframes])
        self._times = np.array([key.time for key in keyframes])
        self._points = np.array([camera.position for camera in cameras])
        self._lenses = np.array([_lens(camera) for camera in cameras])
        self._turns = np.array([quaternion(camera.world_from_camera[:3, :3]) for camera in cameras])
        self._find_velocities()

    def _find_velocities(self) -> None:
        steps = np.diff(self._seconds)
        size = float(np.ptp(self._points, axis=0).max(initial=0.0))
        between = np.array([logarithm(product(conjugate(a), b)) for a, b in pairwise(self._turns)]).reshape(
            -1, 3
        )
        closed = len(steps) > 1 and self._is_closed(size)
        self._point_speeds = velocities(np.diff(self._points, axis=0), steps, SAME * size, closed=closed)
        self._turn_speeds = velocities(between, steps, SAME, closed=closed)
        lenses = np.diff(self._lenses, axis=0)
        # Each number for itself: a pixel of the centre is no measure of the focal length.
        columns = [velocities(lenses[:, [one]], steps, SAME, closed=closed) for one in range(lenses.shape[1])]
        self._lens_speeds = np.hstack(columns)
        self._time_speeds = monotone(np.diff(self._times), steps)

    def _is_closed(self, size: float) -> bool:
        turned = logarithm(product(conjugate(self._turns[0]), self._turns[-1]))
        moved = self._points[-1] - self._points[0]
        return bool(np.linalg.norm(turned) <= SAME and np.linalg.norm(moved) <= SAME * size)

    def at(self, seconds: float) -> Keyframe:
        right = int(np.searchsorted(self._seconds, seconds))
        if self._seconds[right] == seconds:
            return self._keyframes[right]
        step = float(self._seconds[right] - self._seconds[right - 1])
        return self._between(right - 1, right, (seconds - self._seconds[right - 1]) / step, step)

    def track(self) -> FloatArray:
        shares = np.linspace(0, 1, TRACK, endpoint=False)[:, None]
        steps = np.diff(self._seconds)
        ways = [
            hermite(self._points, self._point_speeds, place, place + 1, shares, float(step))
            for place, step in enumerate(steps)
        ]
        return np.concatenate([*ways, self._points[-1:]])

    def _between(self, a: int, b: int, share: float, step: float) -> Keyframe:
        """A share in (0, 1) of the way from keyframe a to b, which is `step` seconds long."""
        point = hermite(self._points, self._point_speeds, a, b, share, step)
        lens = hermite(self._lenses, self._lens_speeds, a, b, share, step)
        time = hermite(self._times[:, None], self._time_speeds, a, b, share, step)
        turn = turned_hermite(self._turns, self._turn_speeds, a, b, share, step)
        rotation = matrix(turn).T
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = rotation, -rotation @ point
        fx, fy = np.exp(lens[:2])
        camera = Camera.nearest(float(fx), float(fy), float(lens[2]), float(lens[3]), *self._size, pose)
        return Keyframe(float(self._seconds[a] + share * step), float(min(max(time[0], 0.0), 1.0)), camera)


def _lens(camera: Camera) -> list[float]:
    """Focal lengths as logarithms, so that they stay positive and zooming is even."""
    return [math.log(camera.fx), math.log(camera.fy), camera.cx, camera.cy]


def velocities(differences: FloatArray, steps: FloatArray, same: float, *, closed: bool) -> FloatArray:
    """(K, D) at K knots, from the (K-1, D) differences over (K-1,) seconds between them.

    That of the parabola through three knots, at most MOST times as fast as the slower segment there; 0 at
    both ends of a difference of at most `same`, since the camera rests there; at the ends of an open path
    that of its first and last segment.
    """
    if not len(steps):
        return np.zeros((1, differences.shape[1]))
    slopes = differences / steps[:, None]
    still = np.linalg.norm(differences, axis=1) <= same
    before, after = np.r_[slopes[-1:], slopes], np.r_[slopes, slopes[:1]]
    earlier, later = np.r_[steps[-1:], steps], np.r_[steps, steps[:1]]
    rests = np.r_[still[-1:], still] | np.r_[still, still[:1]]
    found = (later[:, None] * before + earlier[:, None] * after) / (earlier + later)[:, None]
    speeds = np.linalg.norm(found, axis=1)
    most = MOST * np.minimum(np.linalg.norm(before, axis=1), np.linalg.norm(after, axis=1))
    found *= np.divide(most, speeds, out=np.ones_like(speeds), where=speeds > most)[:, None]
    if not closed:
        found[0], found[-1] = slopes[0], slopes[-1]
        rests[0], rests[-1] = still[0], still[-1]
    found[rests] = 0.0
    return np.asarray(found)


def monotone(differences: FloatArray, steps: FloatArray) -> FloatArray:
    """(K, 1) velocities with which a cubic never leaves the range of its two knots: Fritsch and Butland,
    1984; the harmonic mean of both slopes, 0 where the direction turns or rests."""
    if not len(steps):
        return np.zeros((1, 1))
    slopes = differences / steps
    found = np.r_[slopes[:1], np.zeros(len(slopes) - 1), slopes[-1:]]
    for place in range(1, len(slopes)):
        a, b = slopes[place - 1], slopes[place]
        if a * b > 0:
            first, second = 2 * steps[place] + steps[place - 1], steps[place] + 2 * steps[place - 1]
            found[place] = (first + second) / (first / a + second / b)
    return np.asarray(found[:, None])


def hermite(
    values: FloatArray, speeds: FloatArray, a: int, b: int, share: float | FloatArray, step: float
) -> FloatArray:
    """(D,) of the cubic from knot a to b with the given velocities there; (S, D) for shares (S, 1)."""
    s = share
    start, end = values[a], values[b] - values[a]
    return np.asarray(
        start + (3 - 2 * s) * s * s * end + s * (1 - s) * step * ((1 - s) * speeds[a] - s * speeds[b])
    )
