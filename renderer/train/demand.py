"""What a training will need of memory and disk, told before it starts from the clip and the configuration."""

from __future__ import annotations

from renderer.clip import Clip
from renderer.deformation.spline import MIN_CONTROLS, most_controls
from renderer.harmonics import BANDS
from renderer.train.config import Method, TrainConfig
from renderer.train.events import Planned
from renderer.train.frame_store import MOST_BYTES
from renderer.train.needs import FRAMES_PER_CONTROL_AT_REST, RAW_NUMBERS
from renderer.train.windows import windows_of

PROGRAM = 450_000_000
"""Bytes of a training of a few small frames: libraries and compiled kernels, nearly all of it."""
FRAME, READY, HALF = 9, 8, 2
"""Bytes a pixel of a frame as it is read, as training takes it, and of that at half resolution."""
WORK = 80
"""Bytes a pixel of what is drawn, its slopes, and the pictures on the way."""
COPIES = 6
"""Of the model in memory: its values, two moments, what the window shows and what the end works with.
Measured 5.7 for 1000 frames of 64x48 (tests.benchmarks.train_memory)."""
STORED = 10
"""Of the model on the disk: three checkpoints of three arrays each while the oldest goes, and the model."""
KEPT = 2
"""The same of a window that is finished: its model, and its part of that of the clip."""
PLAIN = RAW_NUMBERS + 3 * BANDS[-1]
"""Numbers of a Gaussian at rest, with harmonics."""
BUMPS, GROWTH = 510, 2
"""Numbers of a Gaussian of deform3dgs, and by how much these multiply in a long run."""
PLANES = 20_000_000
"""Numbers of the planes of endogaussian."""


def demand(clip: Clip, config: TrainConfig) -> Planned:
    """An upper estimate: the clip may turn out to need less. One window of a long clip is in memory at a
    time; all of them are on the disk."""
    windows = windows_of(clip, config)
    longest = max(windows, key=len).of(clip)
    width, height = clip.size
    pixels, fit = width * height, len(longest.train_indices)
    reading, training = FRAME * pixels * fit, (READY + HALF) * pixels * fit
    held = min(reading, MOST_BYTES) + min(training, 2 * MOST_BYTES)
    spilled = max(reading - MOST_BYTES, 0) + max(READY * pixels * fit - MOST_BYTES, 0)
    gaussians = most_gaussians(longest, config)
    model = 4 * _numbers(config.method, gaussians, _controls(longest, config))
    others = len(windows) - 1
    joined = 4 * PLAIN * gaussians * others
    memory = PROGRAM + held + WORK * pixels + COPIES * model + joined
    return Planned(memory, spilled + STORED * model + KEPT * model * others)


def most_gaussians(clip: Clip, config: TrainConfig) -> int:
    """That a training begins with: no more than pixels are trained on."""
    width, height = clip.size
    return min(config.n_gaussians, width * height * len(clip.train_indices))


def _controls(clip: Clip, config: TrainConfig) -> int:
    """Control values of a Gaussian's curves of position and colour, or of colour alone for tissue at rest."""
    if config.n_controls is not None:
        return 2 * config.n_controls
    if "controls" in config.keep:
        return 2 * max(MIN_CONTROLS, len(clip))
    return max(2 * most_controls(len(clip)), len(clip) // FRAMES_PER_CONTROL_AT_REST)


def _numbers(method: Method, count: int, controls: int) -> int:
    """Of the model."""
    plain = count * PLAIN
    numbers = {
        "vesselsplat": plain + 3 * controls * count,
        "deform3dgs": GROWTH * (plain + BUMPS * count),
        "endogaussian": plain + PLANES,
        "static": plain,
    }
    return numbers[method]
