"""The largest circles in what is lit of a small copy, against OpenCV and as drawn."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from enhance.field import MOST_PARTS
from enhance.field_circle import Points
from enhance.field_inscribed import FAR, MOST_HOLE, depths_in, halved, inscribed, without_holes
from enhance.field_regions import Levels, Runs, areas_of, connected

Circle = tuple[float, float, float]


def drawn_in(shape: tuple[int, int], circles: list[Circle]) -> Levels:
    y, x = np.mgrid[: shape[0], : shape[1]]
    lit = [np.hypot(x - at, y - row) <= radius for at, row, radius in circles]
    return np.any(lit, axis=0).astype(np.uint8)


def inscribed_in(lit: Levels) -> Points:
    parts: Runs = connected(lit, 1)
    return np.asarray(inscribed(parts, areas_of(parts), *lit.shape))


@pytest.mark.parametrize("seed", range(60))
def test_depths_are_the_distances_of_opencv(seed: int) -> None:
    rng = np.random.default_rng(seed)
    height, width = rng.integers(1, 81, 2).tolist()
    part = (rng.random((height, width)) > rng.choice([0.3, 0.02, 0.001])).astype(np.uint8)
    if part.all():
        assert (depths_in(part) == FAR**2).all()
        return
    expected = cv2.distanceTransform(part, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    assert np.array_equal(depths_in(part), np.rint(expected**2))


@pytest.mark.parametrize("seed", range(60))
def test_small_holes_are_filled_and_no_others(seed: int) -> None:
    rng = np.random.default_rng(seed)
    height, width = rng.integers(2, 60, 2).tolist()
    lit = (rng.random((height, width)) > rng.choice([0.5, 0.2])).astype(np.uint8)
    lit[rng.integers(height) :, rng.integers(width)] = 1
    parts: Runs = connected(lit, 1)
    largest = cv2.connectedComponents(lit, connectivity=4)[1] == areas_of(parts).argmax()
    expected = largest.copy()
    count, dark = cv2.connectedComponents((~largest).astype(np.uint8), connectivity=4)
    for one in range(1, count):
        hole = dark == one
        is_open = hole[[0, -1]].any() or hole[:, [0, -1]].any()
        expected |= hole & (not is_open and hole.sum() <= MOST_HOLE * largest.sum())
    filled = without_holes(parts, areas_of(parts).argmax(), height, width)
    assert np.array_equal(filled, expected)
    even = expected[: height // 2 * 2, : width // 2 * 2].reshape(height // 2, 2, width // 2, 2)
    assert np.array_equal(halved(filled), even.all(axis=(1, 3)))


@pytest.mark.parametrize(
    "circles",
    [
        [(80, 60, 38), (30, 60, 20)],
        [(40, 60, 36), (112, 60, 36)],
        [(32, 32, 29.5), (90, 32, 29.5), (32, 90, 29.5), (90, 90, 29.5)],
    ],
)
def test_circles_that_touch_are_told_from_each_other(circles: list[Circle]) -> None:
    """With highlights in them."""
    lit = drawn_in((120, 160), circles)
    lit[50:54, 40:46] = 0
    found = inscribed_in(lit)
    assert len(found) == len(circles)
    for circle in circles:
        assert np.abs(found - circle).max(axis=1).min() <= 1.5


def test_one_dented_field_is_not_made_of_circles() -> None:
    lit = drawn_in((120, 160), [(80, 60, 56)])
    lit[:20, 70:90] = lit[50:60, 120:] = 0
    assert len(inscribed_in(lit)) == 0


def test_circles_that_leave_much_of_a_part_are_none_of_it() -> None:
    lit = np.zeros((80, 130), np.uint8)
    lit[10:61, 10:61] = lit[10:61, 66:117] = lit[30:40, 61:66] = 1
    assert len(inscribed_in(lit)) == 0


def test_no_more_circles_are_looked_for_than_tell_that_these_are_no_fields() -> None:
    lit = drawn_in((120, 160), [(x, y, 15) for x in range(16, 150, 29) for y in range(16, 110, 29)])
    assert len(inscribed_in(lit)) in (0, MOST_PARTS + 1)


@pytest.mark.parametrize("shape", [(1, 90), (2, 2), (160, 1)])
def test_a_copy_may_be_narrow(shape: tuple[int, int]) -> None:
    assert len(inscribed_in(np.ones(shape, np.uint8))) == 0
