"""How long, and with how many Gaussians, the report trains each method."""

from __future__ import annotations

from typing import Final

from renderer.clip import Clip
from renderer.train.config import Method, TrainConfig

STEPS: Final[dict[Method, tuple[int, ...]]] = {
    "vesselsplat": (1000, 125, 250, 500),
    "deform3dgs": (1000, 250),
    "endogaussian": (1000, 250),
    "static": (1000, 250),
}
"""Of the runs; the first, which the paper's tables are measured on, is the schedule of all other knobs."""
SEEDS: Final = 3
"""Of the longest runs on the phantom, which are short enough for it."""
PIXELS, USUAL = 640 * 512, TrainConfig().n_gaussians


def schedule(clip: Clip, method: Method = "vesselsplat") -> TrainConfig:
    """Short, with as many Gaussians a pixel as by default at 640x512."""
    width, height = clip.size
    count = max(500, USUAL * width * height // PIXELS)
    return TrainConfig(method=method, iterations=STEPS[method][0], n_gaussians=count)
