"""Distances to the nearest points, against all pairs."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from renderer.train.neighbours import nearest_others, neighbour_distances


def by_all_pairs(points: NDArray[np.float32], wanted: int) -> NDArray[np.float64]:
    exact = points.astype(np.float64)
    squares = ((exact[:, None] - exact[None]) ** 2).sum(axis=2)
    np.fill_diagonal(squares, np.inf)
    nearest: NDArray[np.float64] = np.sqrt(np.sort(squares, axis=1)[:, :wanted].mean(axis=1))
    return nearest


@pytest.mark.parametrize("stretch", [(1, 1, 1), (1, 30, 1), (1e-3, 1e-3, 5e-3), (0, 0, 1)])
def test_distances_are_those_of_all_pairs(stretch: tuple[float, float, float]) -> None:
    points = (np.random.default_rng(0).normal(size=(400, 3)) * stretch).astype(np.float32)
    assert np.allclose(neighbour_distances(points), by_all_pairs(points, 3), rtol=1e-4, atol=1e-12)


def test_an_outlier_and_twins_do_not_mislead_it() -> None:
    points = np.random.default_rng(1).uniform(size=(100, 3)).astype(np.float32)
    points[0] = 1e6
    points[1:5] = points[5]
    got = neighbour_distances(points)
    assert np.allclose(got, by_all_pairs(points, 3), rtol=1e-4)
    assert not got[1:6].any()


@pytest.mark.parametrize("count", [0, 1, 2, 3])
def test_few_points_have_the_neighbours_that_there_are(count: int) -> None:
    points = np.random.default_rng(2).uniform(size=(count, 3)).astype(np.float32)
    expected = by_all_pairs(points, count - 1) if count > 1 else np.zeros(count)
    assert np.allclose(neighbour_distances(points), expected, rtol=1e-5)


@pytest.mark.parametrize(("count", "wanted"), [(200, 31), (5, 31), (1, 31), (0, 31)])
def test_the_nearest_are_those_of_all_pairs_in_order(count: int, wanted: int) -> None:
    points = np.random.default_rng(3).normal(size=(count, 3)).astype(np.float32)
    squares, others = nearest_others(points, wanted)
    exact = ((points[:, None].astype(np.float64) - points[None]) ** 2).sum(axis=2)
    np.fill_diagonal(exact, np.inf)
    expected = np.argsort(exact, axis=1)[:, : max(min(wanted, count - 1), 0)]
    np.testing.assert_array_equal(others, expected)
    np.testing.assert_allclose(squares, np.take_along_axis(exact, expected, axis=1), rtol=1e-5)
