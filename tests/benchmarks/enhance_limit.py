"""What a frame of the paper's method takes at least on this machine; `enhance_speed` prints it.

Memory: the first pass reads the image, the second reads it again and writes the result; what lies between
them is a small part of that. Arithmetic: what a pixel costs a core where the caches hold all of it, as the
slope of the time over two images, so that what a frame costs beside its pixels falls out.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from time import perf_counter

import numba
import numpy as np

from enhance import Enhancer, LiveStatistics
from tests.enhance.pictures import vessels

MOVED = 9
"""Bytes a pixel: RGB is read twice and written once."""
SMALL, LARGE = (128, 1280), (384, 1280)
"""Rows and columns of images that caches hold."""
COPIED = 2**26
"""Bytes that each core copies at once: more than caches hold."""
ROUNDS = 40


@dataclass(frozen=True)
class Limit:
    """Of all cores together, in milliseconds a pixel."""

    memory: float
    arithmetic: float

    def told(self, pixels: int, taken: float) -> str:
        """Of a frame of so many pixels that took so many milliseconds."""
        memory, arithmetic = self.memory * pixels, self.arithmetic * pixels
        least = memory + arithmetic
        parts = (
            f"{arithmetic:.2f} of arithmetic, {memory:.2f} of memory at {MOVED / self.memory / 1e6:.0f} GB/s"
        )
        return f"limit {least:.2f} ms ({parts}): the next frame takes {taken / least:.2f} times as long"


def measured() -> Limit:
    """Takes a second."""
    cores = os.cpu_count() or 1
    return Limit(MOVED / _bytes_a_millisecond(cores), _arithmetic() / cores)


def _bytes_a_millisecond(cores: int) -> float:
    """Read and written by all cores at once."""
    pairs = [(np.ones(COPIED, np.uint8), np.zeros(COPIED, np.uint8)) for _ in range(cores)]
    with ThreadPoolExecutor(cores) as pool:
        taken = _fastest(lambda: list(pool.map(lambda pair: np.copyto(pair[1], pair[0]), pairs)))
    return 2 * COPIED * cores / taken


def _arithmetic() -> float:
    """Milliseconds a pixel of one core."""
    threads = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        small, large = (_frame(*size) for size in (SMALL, LARGE))
    finally:
        numba.set_num_threads(threads)
    return (large - small) / (LARGE[0] * LARGE[1] - SMALL[0] * SMALL[1])


def _frame(height: int, width: int) -> float:
    """Milliseconds of the next frame of a stream."""
    image, stream = vessels(height, width), Enhancer(LiveStatistics())

    def shown() -> None:
        stream.show(image)
        stream.enhance()

    return _fastest(shown)


def _fastest(work: Callable[[], object]) -> float:
    """Milliseconds, of ROUNDS."""

    def once() -> float:
        start = perf_counter()
        work()
        return 1000 * (perf_counter() - start)

    return min(once() for _ in range(ROUNDS))
