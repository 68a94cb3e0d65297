"""Masks mended by hand: what a brush covers, and where an area that grows stops."""

from __future__ import annotations

import math

import numpy as np
import pytest

from renderer.tools.brush import REACH, drawn, grown

EMPTY = np.zeros((120, 160), bool)


@pytest.mark.parametrize("radius", [3.0, 8.5, 20.0])
def test_a_dot_is_a_disc(radius: float) -> None:
    dot = drawn(EMPTY, [(80.0, 60.0)], radius, value=True)
    assert np.count_nonzero(dot) == pytest.approx(math.pi * radius**2, rel=0.12, abs=6)
    rows, columns = np.nonzero(dot)
    assert np.hypot(rows + 0.5 - 60, columns + 0.5 - 80).max() <= radius + 1
    assert (rows.mean() + 0.5, columns.mean() + 0.5) == pytest.approx((60, 80), abs=0.3)


def test_a_line_has_no_gaps_and_erasing_takes_it_back() -> None:
    line = [(20.0, 20.0), (140.0, 100.0)]
    painted = drawn(EMPTY, line, 4, value=True)
    for share in np.linspace(0, 1, 50):
        column, row = np.array(line[0]) * (1 - share) + np.array(line[1]) * share
        assert painted[round(row), round(column)]
    assert not drawn(painted, line, 5, value=False).any()
    assert not EMPTY.any()


@pytest.mark.parametrize("line", [[(-50.0, -50.0)], [(-9.0, 60.0), (400.0, 60.0)], [(1e5, -1e5)]])
def test_a_hand_may_go_beyond_the_image(line: list[tuple[float, float]]) -> None:
    assert drawn(EMPTY, line, 5, value=True).shape == EMPTY.shape
    image = np.full((120, 160, 3), 90, np.uint8)
    assert grown(image, EMPTY, line, 5).shape == EMPTY.shape


def test_an_area_grows_to_the_edges_and_not_beyond() -> None:
    random = np.random.default_rng(0)
    image = np.full((120, 160, 3), (150, 70, 60), float)
    tool = EMPTY.copy()
    tool[40:80, 30:130] = True
    image[tool] = (150, 152, 155)
    image = np.clip(image + random.normal(0, 3, image.shape), 0, 255).astype(np.uint8)
    line = [(50.0, 60.0), (110.0, 60.0)]
    found = grown(image, EMPTY, line, 6)
    assert np.count_nonzero(found & tool) / np.count_nonzero(tool) > 0.95
    assert np.count_nonzero(found & ~tool) < 0.03 * np.count_nonzero(tool)
    np.testing.assert_array_equal(found, grown(image, EMPTY, line, 6))


def test_it_grows_no_farther_than_its_reach_and_keeps_what_was_masked() -> None:
    image = np.full((120, 160, 3), 120, np.uint8)
    before = EMPTY.copy()
    before[:4] = True
    found = grown(image, before, [(80.0, 60.0)], 3)
    assert found[before].all()
    rows, columns = np.nonzero(found & ~before)
    assert np.hypot(rows - 60, columns - 80).max() <= (REACH + 2) * 3
