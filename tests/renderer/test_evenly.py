"""Which few stand for all: both choices, and how they differ."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from renderer.evenly import evenly, evenly_floored

Choose = Callable[[Sequence[int], int], list[int]]


def test_one_choice_takes_the_nearest_and_the_other_the_one_before() -> None:
    assert evenly(range(63), 4) == [0, 21, 41, 62]
    assert evenly_floored(range(63), 4) == [0, 20, 41, 62]


@pytest.mark.parametrize("choose", [evenly, evenly_floored])
@pytest.mark.parametrize("number", [1, 2, 5, 6, 18, 100])
def test_both_ends_are_taken_and_gaps_are_alike(choose: Choose, number: int) -> None:
    found = choose(range(number), 5)
    assert (found[0], found[-1], len(found)) == (0, number - 1, min(number, 5))
    gaps = np.diff(found)
    assert max(gaps, default=1) - min(gaps, default=1) <= 1


@pytest.mark.parametrize("choose", [evenly, evenly_floored])
def test_of_none_there_is_none(choose: Choose) -> None:
    assert choose(range(0), 5) == []
