"""Frames a second of video enhancement, stage by stage and end to end, with and without encoding.

python -m tests.benchmarks.video_speed VIDEO
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Generator, Iterator
from pathlib import Path

from app.ahead import ahead
from app.pictures import ArrayImage
from app.series import Series, open_series
from app.video import write_video
from enhance import EnhanceParams, Enhancer, enhance


def main(video: Path) -> None:
    series = open_series(video)
    first = series.read(0)
    enhance(first)
    size = f"{first.shape[1]}x{first.shape[0]}"
    print(f"{video.name}: {len(series)} frames of {size}, load {os.getloadavg()[0]:.1f}")
    with tempfile.TemporaryDirectory() as folder:
        stages = {
            "read": lambda: exhaust(frames(series)),
            "read, enhance": lambda: exhaust(enhanced(series)),
            "read, enhance, encode": lambda: encode(series, Path(folder) / "out.mp4"),
        }
        for name, run in stages.items():
            began = time.perf_counter()
            run()
            print(f"{name:24s} {len(series) / (time.perf_counter() - began):7.1f} frames/s")


def frames(series: Series) -> Generator[ArrayImage, None, None]:
    yield from (series.read(index) for index in range(len(series)))


def enhanced(series: Series) -> Generator[ArrayImage, None, None]:
    enhancer = Enhancer()
    for frame in ahead(frames(series)):
        enhancer.show(frame)
        yield enhancer.enhance(EnhanceParams()).image


def encode(series: Series, path: Path) -> None:
    write_video(path, ahead(enhanced(series)), series.frames_per_second)


def exhaust(items: Iterator[ArrayImage]) -> None:
    for _ in items:
        pass


if __name__ == "__main__":
    main(Path(sys.argv[1]))
