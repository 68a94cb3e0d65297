"""How much more still tissue flickers once it is enhanced: with statistics of each frame, of the clip, live.

python -m tests.benchmarks.flicker [--data ../shared/data]

Still scenes are the first frame of a clip, 24 times, with noise, light that changes by 2 % and a bright tool
that comes in. Of clips as they are, blocks of tissue that hardly move are looked at; what is left of their
motion counts, too. The bar for still scenes: 1.1 by statistics of the clip and live.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from app.enhancement.clip_statistics import StatisticsRequest, measured
from enhance import (
    EnhanceParams,
    Enhancer,
    LiveStatistics,
    Statistics,
    VesselEnhancer,
    VesselParams,
    enhance,
    enhance_vessels,
    measure,
)
from renderer.clip import ByteImage
from renderer.sources import open_clip

BLOCK: Final = 32
"""Pixels of a block's side."""
STILL: Final = 3.0
"""Grey levels: deviation of a block's details from one frame to the next up to which it is still."""
DARKEST, BRIGHTEST = 24, 230
"""Grey levels of the blocks that count."""
FRAMES: Final = 24
CLIPS: Final = (
    *("clips/laparoscopy_1280x720.mp4", "clips/fetoscopy_470x470/input", "clips/mesentery_stereo"),
    *("clips/sinus_moving_camera", "clips/wall_stereo_moving_camera", "endonerf/pulling_soft_tissues"),
)
Method = Callable[[ByteImage, Statistics | None], ByteImage]


def flicker_gain(images: Sequence[ByteImage], originals: Sequence[ByteImage]) -> float:
    """Mean step of the mean grey of still blocks between neighbouring frames, over that of the originals."""
    after, before = 0.0, 0.0
    for (one, other), (first, second) in zip(pairwise(images), pairwise(originals), strict=True):
        still = still_blocks(first, second)
        after += float(np.abs(_means(other) - _means(one))[still].sum())
        before += float(np.abs(_means(second) - _means(first))[still].sum())
    return after / before if before > 0 else float("nan")


def still_blocks(one: ByteImage, other: ByteImage) -> NDArray[np.bool_]:
    """Whose details stay, whatever the light does."""
    first, second = (_blocks(cv2.GaussianBlur(_grey(image), (0, 0), 1.0)) for image in (one, other))
    level = first.mean(axis=1)
    apart = (first - level[:, None]) - (second - second.mean(axis=1, keepdims=True))
    return np.asarray((apart.std(axis=1) < STILL) & (level > DARKEST) & (level < BRIGHTEST))


def still_scene(image: ByteImage, frames: int = FRAMES) -> list[ByteImage]:
    """One frame seen for a while."""
    rng, (height, width) = np.random.default_rng(0), image.shape[:2]
    scene = []
    for index in range(frames):
        seen = image * (1 + 0.02 * np.sin(index / 3)) + rng.normal(0, 1.5, image.shape)
        seen[: height // 3, : max(0, 3 * index - frames) * width // (4 * frames)] = 200
        scene.append(np.clip(np.rint(seen), 0, 255).astype(np.uint8))
    return scene


def by_paper(image: ByteImage, statistics: Statistics | None = None) -> ByteImage:
    return np.asarray(enhance(image, statistics=statistics).image)


def by_vessel(image: ByteImage, statistics: Statistics | None = None) -> ByteImage:
    return np.asarray(enhance_vessels(image, VesselParams(), statistics=statistics).image)


def live(frames: Sequence[ByteImage], stream: Enhancer | VesselEnhancer) -> list[ByteImage]:
    out = []
    for frame in frames:
        stream.show(frame)
        out.append(np.asarray(stream.enhance().image))
    return out


def gains(frames: Sequence[ByteImage], method: Method, statistics: Statistics | None) -> tuple[float, float]:
    """By statistics of each frame, and by those of the clip."""
    own, clip = ([method(frame, used) for frame in frames] for used in (None, statistics))
    return flicker_gain(own, frames), flicker_gain(clip, frames)


def _grey(image: ByteImage) -> NDArray[np.float32]:
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY).astype(np.float32))


def _blocks(grey: NDArray[np.float32]) -> NDArray[np.float32]:
    rows, columns = (size // BLOCK for size in grey.shape)
    whole = grey[: rows * BLOCK, : columns * BLOCK].reshape(rows, BLOCK, columns, BLOCK)
    return whole.swapaxes(1, 2).reshape(rows * columns, BLOCK * BLOCK)


def _means(image: ByteImage) -> NDArray[np.float32]:
    return np.asarray(_blocks(_grey(image)).mean(axis=1))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    data = parser.parse_args().data
    print(f"{'':32}{'method':>8}{'frame':>8}{'clip':>8}{'live':>8}")
    for name in CLIPS:
        clip = open_clip(data / name)
        moving = [clip.read_image(index) for index in range(min(len(clip), FRAMES))]
        still = still_scene(moving[0])
        of_clip = measured(StatisticsRequest(clip, "clip", EnhanceParams(), "automatic"))
        for label, frames, used in (("still", still, measure(still)), ("as it is", moving, of_clip)):
            for method in (by_paper, by_vessel):
                own, pooled = gains(frames, method, used)
                stream = (Enhancer if method is by_paper else VesselEnhancer)(LiveStatistics())
                smooth, said = flicker_gain(live(frames, stream), frames), f"{Path(name).stem[:20]}, {label}"
                print(f"{said:32}{method.__name__[3:]:>8}{own:8.2f}{pooled:8.2f}{smooth:8.2f}", flush=True)


if __name__ == "__main__":
    main()
