"""Parts of kernels, which own no memory: arrays are given to them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

Function = TypeVar("Function", bound=Callable[..., object])


def part(**options: Any) -> Callable[[Function], Function]:
    """`njit` for a function that kernels call, and that allocates no array, nor returns one.

    numba counts no references there. Otherwise it does so for each array and each view of one, by locked
    additions of which each waits until all before it is stored: a tenth of the second pass.
    """
    compiled = cast(Any, njit)(error_model="numpy", _nrt=False, **options)
    return cast(Callable[[Function], Function], compiled)
