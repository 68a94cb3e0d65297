"""Error against run time of the enhancement: python -m tests.benchmarks.enhance_accuracy [PICTURE]

A picture is brought to each size; without one, drawn tissue is used.
"""

from __future__ import annotations

import os
import sys

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance.accuracy import Row, accuracy
from tests.enhance.pictures import vessels

SIZES = ((640, 512), (1280, 1024), (1920, 1080))


def picture(path: str | None, width: int, height: int) -> NDArray[np.uint8]:
    if path is None:
        return vessels(height, width)
    read = cv2.imread(path)
    if read is None:
        raise SystemExit(f"expected an image, got {path}")
    smaller = read.shape[0] > height
    scaled = cv2.resize(read, (width, height), None, 0, 0, cv2.INTER_AREA if smaller else cv2.INTER_CUBIC)
    return np.ascontiguousarray(scaled[..., ::-1], dtype=np.uint8)


def line(row: Row) -> str:
    bound = "" if row.bound is None else f"{row.bound:9.4f}"
    taken = "" if row.milliseconds is None else f"{row.milliseconds:9.2f}"
    return (
        f"{row.group:12}{row.setting:26}{row.mean:9.4f}{row.p999:9.4f}{row.most:9.4f}{bound:>9}{taken:>9}\n"
    )


def main() -> None:
    path = sys.argv[1] if len(sys.argv) > 1 else None
    for width, height in SIZES:
        sys.stdout.write(f"\n{width} x {height}, load {os.getloadavg()[0]:.1f} of {os.cpu_count()} cores\n")
        sys.stdout.write(
            f"{'error in grey levels':38}{'mean':>9}{'p99.9':>9}{'most':>9}{'bound':>9}{'ms':>9}\n"
        )
        for row in accuracy(picture(path, width, height)):
            sys.stdout.write(line(row))


if __name__ == "__main__":
    main()
