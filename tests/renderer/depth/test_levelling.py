"""Turns of one eye against the other, by what both see."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from renderer.depth.levelling import Level, Matches, level_of


def matches(turn: float, stretch: float, *, rows: float, seed: int, chance: float = 0.0) -> Matches:
    """Of places exact to 0.3 px, a share of which was matched by chance."""
    rng = np.random.default_rng(seed)
    right: NDArray[np.float64] = rng.uniform((0, 0), (640, 512), (200, 2))
    apart = rows + turn * (right[:, 0] - 320) + stretch * (right[:, 1] - 256) + rng.normal(0, 0.3, 200)
    left = right + np.column_stack((rng.uniform(20, 60, 200), apart))
    wild = rng.random(200) < chance
    left[wild] = rng.uniform((0, 0), (640, 512), (int(wild.sum()), 2))
    return left, right


def test_it_is_found_whatever_distance_each_pair_has_and_through_matches_by_chance() -> None:
    pairs = [matches(0.02, -0.004, rows=at * 3.0 - 5, seed=at, chance=0.2) for at in range(4)]
    level = level_of(pairs)
    assert level is not None
    assert level.turn == pytest.approx(0.02, abs=5e-4)
    assert level.stretch == pytest.approx(-0.004, abs=5e-4)


@pytest.mark.parametrize(("turn", "stretch"), [(0.08, 0.0), (0.0, 0.06)])
def test_eyes_of_no_one_scope_are_not_brought_level(turn: float, stretch: float) -> None:
    assert level_of([matches(turn, stretch, rows=0, seed=5)]) is None


def test_too_few_matches_tell_nothing() -> None:
    assert level_of([(np.zeros((0, 2)), np.zeros((0, 2)))]) is None
    assert level_of([(np.zeros((2, 2)), np.ones((2, 2)))]) is None


def test_an_image_is_turned_about_its_middle_as_its_rows_are_apart() -> None:
    image = np.zeros((101, 141, 3), np.uint8)
    image[48:53, 18:23] = 200
    moved = Level(turn=0.04, stretch=0.0).applied(image)[..., 0].astype(float)
    y, x = np.indices(moved.shape)
    middle = (moved * y).sum() / moved.sum(), (moved * x).sum() / moved.sum()
    assert middle[0] == pytest.approx(50 + 0.04 * (20 - 70), abs=0.05)
    assert middle[1] == pytest.approx(20, abs=0.05)
