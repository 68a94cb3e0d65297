"""What leaving a part out of a reconstruction saves and costs: runs with and without it, side by side."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from renderer.clip import Clip
from renderer.train.config import TrainConfig
from renderer.train.events import Evaluated, Finished, Omission, Started
from renderer.train.frames import train_frame
from renderer.train.initialize import scene_size, with_points
from renderer.train.methods import recipe_for
from renderer.train.model import TrainModel
from renderer.train.needs import decide
from renderer.train.trainer import split, train


@dataclass(frozen=True)
class Side:
    """One of two runs."""

    milliseconds: float
    """A step: median of steps at full size that both models take in turns."""
    spread: float
    """Half of the distance between the quartiles."""
    seconds: float
    """Of the whole run, which suffers from other load."""
    megabytes: float
    """Of the model's numbers with their two moments."""
    psnr: float
    """dB, of training frames that are held out of the fit; NaN where there are too few frames."""
    omitted: tuple[Omission, ...]


def compared(
    clip: Clip, without: TrainConfig, kept: TrainConfig, timed_steps: int = 120
) -> tuple[Side, Side]:
    """Without and with; both configurations hold frames out (`hold_out`)."""
    configs = without, kept
    times = step_times(clip, configs, timed_steps)
    first, second = (_measured(clip, config, *each) for config, each in zip(configs, times, strict=True))
    return first, second


def step_times(clip: Clip, configs: Sequence[TrainConfig], steps: int) -> list[tuple[float, float]]:
    """Median and spread of a step of each configuration in ms, taken in turns; those before every frame was
    seen once, or the first half, do not count."""
    models, frames = [], [clip.read_frame(index) for index in split(clip, configs[0])[0]]
    seeds = with_points(frames, clip.points)
    size = scene_size(seeds)
    for config in configs:
        recipe = recipe_for(config, decide(clip, frames, config))
        raw = recipe.initialize(seeds)
        models.append(TrainModel(raw, recipe.make_trainer(raw, seeds, size), recipe, size))
    views, first = [train_frame(frame) for frame in frames], configs[0].iterations // 2
    laps = np.zeros((steps, len(models)))
    for step, place in np.ndindex(laps.shape):
        began = perf_counter()
        models[place].step(views[step % len(views)], min(first + step, configs[0].iterations - 1))
        laps[step, place] = 1000 * (perf_counter() - began)
    low, middle, high = np.percentile(laps[min(len(views), steps // 2) :], (25, 50, 75), axis=0)
    return [(float(m), float(top - bottom) / 2) for bottom, m, top in zip(low, middle, high, strict=True)]


def _measured(clip: Clip, config: TrainConfig, milliseconds: float, spread: float) -> Side:
    events = list(train(clip, config))
    started, finished = events[0], events[-1]
    assert isinstance(started, Started)
    assert isinstance(finished, Finished)
    numbers = sum(value.nbytes for value in finished.model.arrays().values())
    measured = [event.psnr for event in events if isinstance(event, Evaluated)]
    psnr = measured[-1] if measured else math.nan
    omitted = (*started.omitted, *finished.omitted)
    return Side(milliseconds, spread, finished.seconds, 3 * numbers / 1e6, psnr, omitted)
