"""How fast enhancement is, and how much faster than plain numpy and OpenCV.

Every round times the yardstick and each case once, in one process, so that a busy machine slows them alike;
medians and minima are over the rounds. A ratio is the yardstick's median over the case's. The bar: 12 times
faster; of a moved slider, half the time of the next frame, or of what is 12 times faster.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from dataclasses import replace
from time import perf_counter

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance import EnhanceParams, Enhancer, enhance
from tests.benchmarks.yardstick import enhance_plainly
from tests.enhance.pictures import vessels

SIZES = ((640, 512), (1280, 1024), (1920, 1080))
ROUNDS = 25
BAR = 12
DEFAULT = EnhanceParams()
SLIDERS = {
    "z": lambda t: replace(DEFAULT, z=t),
    "P": lambda t: replace(DEFAULT, p=0.4 + t),
    "P = 1/2, z": lambda t: replace(DEFAULT, p=0.5, z=t),
    "middle radius": lambda t: replace(DEFAULT, radii=(4, 12 + round(ROUNDS * t), 64)),
    "smallest radius": lambda t: replace(DEFAULT, radii=(2 + round(ROUNDS * t), 16, 64)),
    "largest radius": lambda t: replace(DEFAULT, radii=(4, 16, 65 + round(ROUNDS * t))),
    "eps": lambda t: replace(DEFAULT, eps=0.001 + 0.01 * t),
    "d-factor": lambda t: replace(DEFAULT, d_factor=0.2 + t),
    "keep black": lambda t: replace(DEFAULT, keep_black=t < 0.5),
}


def cases(image: NDArray[np.uint8]) -> dict[str, Callable[[int], object]]:
    """What is timed, by name; each takes the number of the round."""
    stream = Enhancer()

    def next_frame(_: int) -> None:
        stream.show(image)
        stream.enhance()

    def moved(make: Callable[[float], EnhanceParams]) -> Callable[[int], object]:
        still = Enhancer()
        still.show(image)
        still.enhance(DEFAULT)
        return lambda index: still.enhance(make((index % ROUNDS) / ROUNDS))

    return {
        "yardstick": lambda _: enhance_plainly(image),
        "enhance()": lambda _: enhance(image),
        "Enhancer, next frame": next_frame,
        **{f"Enhancer, moved {name}": moved(make) for name, make in SLIDERS.items()},
    }


def times(image: NDArray[np.uint8]) -> dict[str, NDArray[np.float64]]:
    """(ROUNDS,) milliseconds of each case."""
    works = cases(image)
    taken = {name: np.empty(ROUNDS) for name in works}
    for work in works.values():
        for index in range(-3, 0):
            work(index)
    for index in range(ROUNDS):
        for name, work in works.items():
            start = perf_counter()
            work(index)
            taken[name][index] = 1000 * (perf_counter() - start)
    return taken


def passes(name: str, ratio: float, of_frame: float) -> bool:
    return ratio >= 2 * BAR or of_frame <= 0.5 if "moved" in name else ratio >= BAR


def main() -> None:
    cv2.setNumThreads(os.cpu_count() or 1)
    for width, height in SIZES:
        image = vessels(height, width)
        taken = times(image)
        plain, frame = np.median(taken["yardstick"]), np.median(taken["Enhancer, next frame"])
        sys.stdout.write(f"\n{width} x {height}, load {os.getloadavg()[0]:.1f} of {os.cpu_count()} cores\n")
        heads = f"{'median ms':>10}{'min ms':>9}{'x faster':>10}{'of a frame':>12}{'bar':>7}"
        sys.stdout.write(f"{'':32}{heads}\n")
        for name, values in taken.items():
            middle = np.median(values)
            ratio, of_frame = float(plain / middle), float(middle / frame)
            verdict = "" if name == "yardstick" else "pass" if passes(name, ratio, of_frame) else "FAIL"
            sys.stdout.write(
                f"{name:32}{middle:10.2f}{values.min():9.2f}{ratio:10.1f}{of_frame:12.2f}{verdict:>7}\n"
            )


if __name__ == "__main__":
    main()
