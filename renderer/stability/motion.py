"""What moves Gaussians in time: splines with nodes, bumps (Deform3DGS), planes (HexPlane)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from renderer.deformation.fdm import CENTRE, CHANNELS, WEIGHT, WIDTH, FlexibleMotion, add_bumps
from renderer.deformation.hexplane import LANES, Layout, lines_at, sample, time_taps, within_box
from renderer.deformation.nodes import attach
from renderer.deformation.spline import spline_taps
from renderer.stability.row import Row
from renderer.stability.scenes import CAMERA

FloatArray = NDArray[np.float64]
TIMES = (0.0, 1e-9, 0.1, 0.5, 1 - 1e-9, 1.0, -3.0, 3.0)
"""The last two lie outside a clip and are those of its ends."""


def rows() -> Iterator[Row]:
    """See the file."""
    yield from _splines()
    yield from _nodes()
    yield from _bumps()
    yield from _planes()


def _splines() -> Iterator[Row]:
    """Weights against the recursion of Cox and de Boor."""
    for controls in (4, 17, 1000):
        worst = 0.0
        for time in TIMES:
            first, weights = spline_taps(time, controls)
            wanted = _de_boor(min(max(time, 0.0), 1.0), controls)
            got = np.zeros(controls)
            got[first : first + 4] = weights
            worst = max(worst, float(np.abs(got - wanted).max()), abs(float(weights.sum()) - 1))
        yield Row(
            "cubic spline in time", f"{controls} control values, at and beyond both ends", worst, 2e-7, "of 1"
        )
    jumps = []
    for knot in range(1, 14):
        before, after = (_weights(knot / 14 + side, 17) for side in (-1e-7, 1e-7))
        jumps.append(float(np.abs(before - after).max()))
    yield Row("cubic spline in time", "step across a knot of 2e-7 of the clip", max(jumps), 5e-6, "of 1")
    yield Row("cubic spline in time", "3 control values are not refused", float(not _refused()), 0, "cases",
              "ValueError: at least four")  # fmt: skip


def _weights(time: float, controls: int) -> FloatArray:
    first, weights = spline_taps(time, controls)
    whole = np.zeros(controls)
    whole[first : first + 4] = weights
    return whole


def _refused() -> bool:
    try:
        spline_taps(0.5, 3)
    except ValueError:
        return True
    return False


def _de_boor(time: float, controls: int) -> FloatArray:
    """The uniform cubic basis (K,) at a time, by recursion."""
    place = time * (controls - 3)
    knots = np.arange(-3.0, controls + 1)
    last = controls - 3
    basis = ((knots[:-1] <= place) & (place < knots[1:])).astype(float)
    if place == last:
        basis[:] = 0
        basis[np.searchsorted(knots, last) - 1] = 1
    for degree in range(1, 4):
        count = len(knots) - 1 - degree
        left = (place - knots[:count]) / degree * basis[:count]
        right = (knots[degree + 1 : degree + 1 + count] - place) / degree * basis[1 : count + 1]
        basis = left + right
    return basis


def _nodes() -> Iterator[Row]:
    """Gaussians in the view, beside it, behind the camera and in its centre hold on to some node."""
    means = np.array(
        [[0, 0, 10], [1e9, 0, 10], [0, 0, -10], [0, 0, 0], [np.nan, 0, 10], [-1e-9, 0, 1e-9]], np.float32
    )
    indices, weights = attach(means, CAMERA, (20, 16))
    apart = float(np.abs(weights.sum(axis=1) - 1).max())
    outside = np.count_nonzero((indices < 0) | (indices >= 320))
    yield Row("motion nodes", "weights of Gaussians anywhere sum to 1", apart, 1e-6, "of 1")
    yield Row("motion nodes", "nodes that do not exist", float(outside), 0, "nodes")


def _bumps() -> Iterator[Row]:
    """The sum of bumps against its formula, in units of the sum of the absolute weights."""
    cases = {
        "width -> 0": (0.0, 1.0),
        "width of 1e-20": (1e-20, 1.0),
        "width of 1e4": (1e4, 1.0),
        "negative width": (-0.1, 1.0),
        "weight of 1e6": (0.06, 1e6),
        "width 0, weight 1e6": (0.0, 1e6),
    }
    for name, (width, weight) in cases.items():
        bumps = np.zeros((17, 3, 3, CHANNELS), np.float32)
        bumps[:, :, CENTRE] = np.linspace(0, 1, 17)[:, None, None]
        bumps[:, :, WIDTH] = width
        bumps[:, :, WEIGHT] = weight * np.random.default_rng(0).normal(size=(17, 3, CHANNELS))
        motion, worst = FlexibleMotion(bumps), 0.0
        exact = bumps.astype(np.float64)
        size = np.abs(exact[:, :, WEIGHT]).sum(axis=0)
        for time in (*TIMES[:6], float(bumps[3, 0, CENTRE, 0])):
            got = np.zeros((3, CHANNELS), np.float32)
            add_bumps(motion.bumps, motion.spans, time, got)
            u = (time - exact[:, :, CENTRE]) ** 2 / (exact[:, :, WIDTH] ** 2 + 1e-4)
            wanted = (exact[:, :, WEIGHT] * np.exp(-(u**2))).sum(axis=0)
            worst = max(worst, float((np.abs(got - wanted) / size).max()))
        yield Row("bumps in time (FDM)", name, worst, 1e-6, "of the weights",
                  "1e-4 is added to the squared width, as published" if width == 0 else "")  # fmt: skip


def _planes() -> Iterator[Row]:
    """Features of points on and beyond the box, against the same sums in float64."""
    layout = Layout.of(np.array([[9, 7, 2], [64, 48, 16]], np.int32))
    rng = np.random.default_rng(2)
    planes = rng.normal(size=(1, layout.n_plane_cells, LANES))
    times = rng.normal(size=(25, 1, layout.n_line_cells, LANES))
    means = rng.uniform(-5, 5, (200, 3)).astype(np.float32)
    boxes = {
        "within the box": np.array([[-5, -5, -5], [5, 5, 5]], np.float32),
        "on the edges of the box": np.array([means.min(axis=0), means.max(axis=0)], np.float32),
        "far beyond the box": np.array([[-1e-3] * 3, [1e-3] * 3], np.float32),
        "a box without depth": np.array([[-5, -5, 0], [5, 5, 0]], np.float32),
        "a box of one point": np.zeros((2, 3), np.float32),
        "a box of 1e30": np.array([[-1e30] * 3, [1e30] * 3], np.float32),
    }
    for name, box in boxes.items():
        points, worst = within_box(means, box), 0.0
        for time in TIMES:
            got = _features(layout, planes.astype(np.float32), times.astype(np.float32), points, time)
            wanted = _features(layout, planes, times, points.astype(np.float64), time)
            worst = max(worst, float(np.abs(got - wanted).max()) / max(1.0, float(np.abs(wanted).max())))
        yield Row("planes in space and time", name, worst, 1e-5, "of the largest")
    rows = [time_taps(time, 25)[0] for time in TIMES]
    yield Row("planes in space and time", "rows of time that do not exist",
              float(sum(row < 0 or row > 23 for row in rows)), 0, "rows")  # fmt: skip


def _features(
    layout: Layout, planes: NDArray[Any], times: NDArray[Any], points: NDArray[Any], time: float
) -> NDArray[Any]:
    """In the precision of what is given."""
    lines: NDArray[Any] = _exact_lines(times, time)
    if times.dtype == np.float32:
        lines = lines_at(times, time)
    features = np.empty((len(points), len(layout.resolutions) * LANES), planes.dtype)
    sample(planes, lines, layout.resolutions, layout.planes, layout.lines, points, features)
    return features


def _exact_lines(times: FloatArray, time: float) -> FloatArray:
    place = min(max(time, 0.0), 1.0) * (len(times) - 1)
    row = min(int(place), len(times) - 2)
    return np.asarray((1 - (place - row)) * times[row] + (place - row) * times[row + 1])
