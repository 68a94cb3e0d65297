"""Depth where none was measured."""

from __future__ import annotations

import numpy as np
import pytest

from renderer.depth.filled_depth import filled_depth

SHAPE = (60, 83)


def plane() -> np.ndarray:
    """Depth of a tilted plane: its inverse is linear over the image."""
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]]
    return (1 / (0.02 - 5e-5 * rows + 3e-5 * columns)).astype(np.float32)


def test_measured_depth_stays() -> None:
    measured = np.random.default_rng(0).uniform(size=SHAPE) < 0.3
    filled = filled_depth(plane(), measured)
    np.testing.assert_array_equal(filled[measured], plane()[measured])


def test_one_depth_is_that_depth_everywhere() -> None:
    measured = np.zeros(SHAPE, bool)
    measured[7, 80] = True
    filled = filled_depth(np.full(SHAPE, 42, np.float32), measured)
    np.testing.assert_allclose(filled, 42, rtol=1e-6)


@pytest.mark.parametrize("side", [6, 16])
def test_a_hole_in_a_plane_is_filled_nearly_as_the_plane_goes_on(side: int) -> None:
    measured = np.ones(SHAPE, bool)
    hole = np.s_[20 : 20 + side, 30 : 30 + side]
    measured[hole] = False
    true = plane()[hole]
    error = np.abs(filled_depth(plane(), measured)[hole] / true - 1)
    assert error.max() < 0.5 * (true.max() / true.min() - 1)


def test_nothing_is_filled_where_nothing_is_measured() -> None:
    assert not filled_depth(plane(), np.zeros(SHAPE, bool)).any()


def test_filled_depth_lies_within_what_was_measured() -> None:
    rng = np.random.default_rng(1)
    depth = rng.uniform(10, 90, SHAPE).astype(np.float32)
    measured = rng.uniform(size=SHAPE) < 0.05
    filled = filled_depth(depth, measured)
    assert filled.min() >= depth[measured].min() * 0.9999
    assert filled.max() <= depth[measured].max() * 1.0001
