"""The temporal basis and the motion nodes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from renderer.camera import Camera
from renderer.deformation.nodes import Attachment, add_shared, attach, gather_gradients, node_grid
from renderer.deformation.spline import add_curve, controls_for, spline_taps

times = st.floats(0, 1)
counts = st.integers(4, 60)


@given(times, counts)
def test_weights_are_a_partition_of_unity(time: float, count: int) -> None:
    first, weights = spline_taps(time, count)
    assert 0 <= first <= count - 4
    assert (weights >= 0).all()
    assert weights.sum() == pytest.approx(1.0, abs=1e-6)


@given(times, counts)
def test_straight_line_is_reproduced(time: float, count: int) -> None:
    """A cubic B-spline of control values on a line is that line (Schoenberg): constant speed stays so."""
    controls = (np.arange(count, dtype=np.float32) - 1)[None, :, None] / (count - 3)
    out = np.zeros((1, 1), np.float32)
    add_curve(controls, *spline_taps(time, count), out)
    assert out[0, 0] == pytest.approx(time, abs=1e-5)


def test_every_frame_time_has_support() -> None:
    """No gaps between basis functions: Deform3DGS starts with 16 of 63 frames without any."""
    for n_frames in (1, 5, 24, 63, 1000):
        count = controls_for(n_frames)
        for index in range(n_frames):
            assert spline_taps(index / n_frames, count)[1].max() > 0.1


def test_curve_is_smooth_across_segments() -> None:
    """Second differences shrink as h^2 everywhere, knots included, as for a C2 curve."""
    controls = np.random.default_rng(0).normal(size=(1, 9, 1)).astype(np.float32)

    def value(time: float) -> float:
        first, weights = spline_taps(time, 9)
        return float(controls[0, first : first + 4, 0].astype(np.float64) @ weights.astype(np.float64))

    knots = np.arange(1, 6) / 6
    for knot in knots:
        left = value(knot) - 2 * value(knot - 0.01) + value(knot - 0.02)
        right = value(knot + 0.02) - 2 * value(knot + 0.01) + value(knot)
        assert abs(left - right) < 0.02


def test_too_few_controls_is_an_error() -> None:
    with pytest.raises(ValueError, match="at least 4"):
        spline_taps(0.5, 3)


def test_attachment_interpolates_a_linear_field_exactly() -> None:
    camera = Camera(100, 100, 64, 48, 128, 96)
    rng = np.random.default_rng(1)
    pixels = rng.uniform((0, 0), (128, 96), (50, 2))
    means = np.stack([(pixels[:, 0] - 64) / 10, (pixels[:, 1] - 48) / 10, np.full(50, 10.0)], 1).astype(
        np.float32
    )
    grid = node_grid(camera, 9)
    indices, weights = attach(means, camera, grid)
    assert np.allclose(weights.sum(1), 1, atol=1e-6)
    column, row = np.meshgrid(np.arange(grid[0]), np.arange(grid[1]))
    nodes = (2 * column / (grid[0] - 1) - 3 * row / (grid[1] - 1)).reshape(-1, 1).astype(np.float32)
    out = np.zeros((50, 1), np.float32)
    add_shared(nodes, indices, weights, out)
    assert np.allclose(out[:, 0], 2 * pixels[:, 0] / 128 - 3 * pixels[:, 1] / 96, atol=1e-4)


def test_attachment_outside_the_view_is_finite() -> None:
    camera = Camera(100, 100, 64, 48, 128, 96)
    means = np.array([[1e6, 0, 1], [0, -1e6, 1], [0, 0, 0], [1, 1, -5]], np.float32)
    indices, weights = attach(means, camera, (9, 7))
    assert (indices >= 0).all()
    assert (indices < 63).all()
    assert np.allclose(weights.sum(1), 1, atol=1e-6)


def test_gather_is_the_transpose_of_add_shared() -> None:
    """<A x, y> = <x, A^T y> for every x, y."""
    rng = np.random.default_rng(2)
    indices = rng.integers(0, 12, (30, 4)).astype(np.int32)
    weights = rng.uniform(0, 1, (30, 4)).astype(np.float32)
    nodes, gradients = (
        rng.normal(size=(12, 3)).astype(np.float32),
        rng.normal(size=(30, 3)).astype(np.float32),
    )
    forward = np.zeros((30, 3), np.float32)
    add_shared(nodes, indices, weights, forward)
    links = Attachment.transposed(indices, weights, 12)
    backward, touched = np.empty((12, 3), np.float32), np.empty(12, bool)
    gather_gradients(links.starts, links.gaussians, links.weights, gradients, backward, touched)
    assert (forward * gradients).sum() == pytest.approx((nodes * backward).sum(), rel=1e-4)
    assert touched.tolist() == [bool(m in indices) for m in range(12)]
