"""Frames a second of video enhancement, stage by stage and end to end, with and without encoding.

python -m tests.benchmarks.video_speed VIDEO [paper|vessel]
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Generator, Iterable
from pathlib import Path

from app.enhancement.methods import EnhancementSettings, MethodEnhancer
from app.files.image_files import ArrayImage
from app.files.image_series import Series, open_series
from app.files.stepping import ahead
from app.files.video import write_video
from enhance import EnhanceParams
from enhance.vessel import VesselParams

LOOKS: dict[str, EnhancementSettings] = {"paper": EnhanceParams(), "vessel": VesselParams()}


def main(video: Path, name: str = "paper") -> None:
    series = open_series(video)
    first = series.read(0)
    look = LOOKS[name]
    exhaust(enhanced((one for one in (first,)), look))
    size = f"{first.shape[1]}x{first.shape[0]}"
    print(f"{name}, {video.name}: {len(series)} frames of {size}, load {os.getloadavg()[0]:.1f}")
    with tempfile.TemporaryDirectory() as folder:
        stages = {
            "read": lambda: exhaust(frames(series)),
            "read, enhance": lambda: exhaust(enhanced(frames(series), look)),
            "read, enhance, encode": lambda: encode(series, look, Path(folder) / "out.mp4"),
        }
        for stage, run in stages.items():
            began = time.perf_counter()
            run()
            print(f"{stage:24s} {len(series) / (time.perf_counter() - began):7.1f} frames/s")


def frames(series: Series) -> Generator[ArrayImage, None, None]:
    yield from (series.read(index) for index in range(len(series)))


def enhanced(
    pictures: Generator[ArrayImage, None, None], look: EnhancementSettings
) -> Generator[ArrayImage, None, None]:
    enhancer = MethodEnhancer()
    for picture in ahead(pictures):
        enhancer.show(picture)
        yield enhancer.enhance(look).image


def encode(series: Series, look: EnhancementSettings, path: Path) -> None:
    write_video(path, ahead(enhanced(frames(series), look)), series.timing)


def exhaust(items: Iterable[ArrayImage]) -> None:
    for _ in items:
        pass


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:3])
