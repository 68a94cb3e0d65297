"""Results are the caller's own for as long as anything reads them; only what is dropped is written again."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from enhance import EnhanceParams, Enhancer, enhance
from enhance.result_memory import ResultMemory
from tests.enhance.pictures import vessels

ONE, OTHER = vessels(96, 128), vessels(96, 128, 7)
HOLDS: dict[str, Callable[[NDArray[Any]], Any]] = {
    "itself": lambda image: image,
    "rows": lambda image: image[10:20],
    "rows of rows": lambda image: image[10:][::2],
    "flat": lambda image: image.reshape(-1),
    "other type": lambda image: image.view(np.int8),
    "turned": lambda image: image.transpose(2, 0, 1),
    "memory": memoryview,
    "iterator": lambda image: image.flat,
}


def address(image: NDArray[Any]) -> int:
    return int(image.__array_interface__["data"][0])


@pytest.mark.parametrize("hold", HOLDS.values(), ids=HOLDS.keys())
def test_what_reads_a_result_keeps_it(hold: Callable[[NDArray[Any]], Any]) -> None:
    expected = np.array(hold(enhance(ONE).image))
    held = hold(enhance(ONE).image)
    for _ in range(3):
        enhance(OTHER)
    assert np.array_equal(np.array(held), expected)


def test_memory_of_a_result_that_is_dropped_is_used_again() -> None:
    memory = ResultMemory()
    first, second = memory.like(ONE), memory.like(ONE)
    assert not np.shares_memory(first, second)
    place = address(second)
    del second
    third = memory.like(ONE)
    assert address(third) == place
    assert memory.size == third.nbytes


@pytest.mark.parametrize("other", [ONE[1:], ONE.astype(np.float32)])
def test_memory_of_another_shape_or_type_is_new(other: NDArray[Any]) -> None:
    memory = ResultMemory()
    memory.like(ONE)
    given = memory.like(other)
    assert (given.shape, given.dtype) == (other.shape, other.dtype)
    assert memory.size == other.nbytes


def test_results_of_one_enhancer_are_apart() -> None:
    enhancer = Enhancer()
    enhancer.show(ONE)
    results = [enhancer.enhance(EnhanceParams(z=z)).image for z in (0.0, 0.4, 0.8)]
    for z, result in zip((0.0, 0.4, 0.8), results, strict=True):
        assert np.array_equal(result, enhance(ONE, EnhanceParams(z=z)).image)
