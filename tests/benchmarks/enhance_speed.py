"""How fast enhancement is, and how much faster than plain numpy and OpenCV.

Every round times the yardstick and each case once, in one process, so that a busy machine slows them alike;
medians and minima are over the rounds. A ratio is the yardstick's median over the case's. The bars: the next
frame of a live stream 12 times faster (at 640x512, 8), one image 10 times (6); a moved slider half the time
of the next frame, or of what is 12 times faster; `vessel` at most twice the time of the paper's method; and
either method's next frame of 3840x2160 in 33 ms. How far the next frame is from what this machine allows is
told below each size, see `enhance_limit`.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from time import perf_counter

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance import EnhanceParams, Enhancer, LiveStatistics, VesselEnhancer, enhance, enhance_vessels
from tests.benchmarks.enhance_limit import measured
from tests.benchmarks.yardstick import enhance_plainly
from tests.enhance.pictures import vessels

SIZES = ((640, 512), (1280, 1024), (1920, 1080), (3840, 2160))
ROUNDS = 25
BAR = 12
FRAME, VESSEL_FRAME = "Enhancer, next frame", "VesselEnhancer, next frame"
ONE, VESSEL_ONE = "enhance()", "enhance_vessels()"
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

    def next_frame(stream: Enhancer | VesselEnhancer) -> Callable[[int], object]:
        def shown(_: int) -> None:
            stream.show(image)
            stream.enhance()

        return shown

    def moved(make: Callable[[float], EnhanceParams]) -> Callable[[int], object]:
        still = Enhancer()
        still.show(image)
        still.enhance(DEFAULT)
        return lambda index: still.enhance(make((index % ROUNDS) / ROUNDS))

    return {
        "yardstick": lambda _: enhance_plainly(image),
        ONE: lambda _: enhance(image),
        FRAME: next_frame(Enhancer(LiveStatistics())),
        VESSEL_ONE: lambda _: enhance_vessels(image),
        VESSEL_FRAME: next_frame(VesselEnhancer()),
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


def passes(name: str, middles: Mapping[str, float], width: int) -> bool:
    taken, small = middles[name], width <= 640
    ratio = middles["yardstick"] / taken
    if "moved" in name:
        return ratio >= 2 * BAR or taken <= 0.5 * middles[FRAME]
    if width >= 3840 and "next" in name:
        return taken <= 33
    if name in (VESSEL_ONE, VESSEL_FRAME):
        return taken <= 2 * middles[ONE if name == VESSEL_ONE else FRAME]
    return ratio >= ((6 if small else 10) if name == ONE else (8 if small else BAR))


def main() -> None:
    cv2.setNumThreads(os.cpu_count() or 1)
    limit = measured()
    for width, height in SIZES:
        image = vessels(height, width)
        taken = times(image)
        middles = {name: float(np.median(values)) for name, values in taken.items()}
        sys.stdout.write(f"\n{width} x {height}, load {os.getloadavg()[0]:.1f} of {os.cpu_count()} cores\n")
        heads = f"{'median ms':>10}{'min ms':>9}{'x faster':>10}{'of a frame':>12}{'bar':>7}"
        sys.stdout.write(f"{'':32}{heads}\n")
        for name, values in taken.items():
            middle = middles[name]
            ratio, of_frame = middles["yardstick"] / middle, middle / middles[FRAME]
            verdict = "" if name == "yardstick" else "pass" if passes(name, middles, width) else "FAIL"
            sys.stdout.write(
                f"{name:32}{middle:10.2f}{values.min():9.2f}{ratio:10.1f}{of_frame:12.2f}{verdict:>7}\n"
            )
        sys.stdout.write(f"{limit.told(width * height, middles[FRAME])}\n")


if __name__ == "__main__":
    main()
