"""What leaving a part out of a reconstruction saves and costs: runs with and without it, side by side."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count

from renderer.clip import Clip
from renderer.gaussians import DynamicGaussians
from renderer.measuring.interleaved_timing import Laps, interleaved_times
from renderer.train.config import TrainConfig
from renderer.train.events import Evaluated, Finished, Omission, Started, TrainEvent
from renderer.train.frame_store import FrameStore
from renderer.train.frames import TrainFrame, train_frame
from renderer.train.held_out import evaluated
from renderer.train.initialize import scene_size, with_points
from renderer.train.methods import recipe_for
from renderer.train.model import TrainModel
from renderer.train.needs import decide
from renderer.train.trainer import split
from renderer.train.training import train


@dataclass(frozen=True)
class Side:
    """One of the runs that are compared."""

    milliseconds: float
    """A step: median of steps at full size that the models of all runs take in turns."""
    spread: float
    """Half of the distance between the quartiles."""
    seconds: float
    """Of the whole run, which suffers from other load."""
    megabytes: float
    """Of the model's numbers with their two moments."""
    psnr: float
    """dB, of training frames that are held out of the fit; of those fitted where none can be held out."""
    omitted: tuple[Omission, ...]


def ablation(clip: Clip, configs: Sequence[TrainConfig], timed_steps: int = 120) -> Iterator[Side]:
    """One for each configuration, trained when it is asked for; all hold frames out (`hold_out`)."""
    for config, step in zip(configs, step_times([(clip, configs)], timed_steps), strict=True):
        yield _measured(clip, config, step)


def step_times(runs: Sequence[tuple[Clip, Sequence[TrainConfig]]], steps: int) -> list[Laps]:
    """Of a step of every configuration of every clip, all taken in turns; those before every frame was seen
    once, or the first half, do not count."""
    walkers = [walker for clip, configs in runs for walker in _walkers(clip, configs)]
    works = [partial(_step_on, walker, count()) for walker in walkers]
    times = []
    # The first step of each is the lap that does not count.
    for walker, taken in zip(walkers, interleaved_times(works, steps - 1), strict=True):
        times.append(Laps.of(taken[min(len(walker.views), steps // 2) - 1 :]))
    return times


def _step_on(walker: _Walker, numbers: Iterator[int]) -> None:
    walker.step(next(numbers))


@dataclass(frozen=True, eq=False)
class _Walker:
    """A model that takes steps of the second half of its schedule, at full size."""

    model: TrainModel
    views: Sequence[TrainFrame]
    iterations: int

    def step(self, number: int) -> None:
        """The next of its views."""
        at = min(self.iterations // 2 + number, self.iterations - 1)
        self.model.step(self.views[number % len(self.views)], at)


def _walkers(clip: Clip, configs: Sequence[TrainConfig]) -> Iterator[_Walker]:
    frames = FrameStore.of(clip.read_frame(index) for index in split(clip, configs[0])[0])
    seeds = FrameStore.of(with_points(frames, clip.points))
    size, views = scene_size(seeds), FrameStore.of(train_frame(frame) for frame in frames)
    for config in configs:
        recipe = recipe_for(config, decide(clip, frames, config, follow=seeds))
        raw = recipe.initialize(seeds)
        model = TrainModel(raw, recipe.make_trainer(raw, seeds, size), recipe, size)
        yield _Walker(model, views, config.iterations)


def _measured(clip: Clip, config: TrainConfig, step: Laps) -> Side:
    events = list(train(clip, config))
    started, finished = events[0], events[-1]
    assert isinstance(started, Started)
    assert isinstance(finished, Finished)
    return Side(
        milliseconds=1e3 * step.median,
        spread=1e3 * step.spread,
        seconds=finished.seconds,
        megabytes=3 * finished.model.n_bytes / 1e6,
        psnr=_psnr(clip, config, events, finished.model),
        omitted=(*started.omitted, *finished.omitted),
    )


def _psnr(clip: Clip, config: TrainConfig, events: Sequence[TrainEvent], model: DynamicGaussians) -> float:
    measured = [event.psnr for event in events if isinstance(event, Evaluated)]
    if measured:
        return measured[-1]
    frames = FrameStore.of(clip.read_frame(index) for index in clip.train_indices)
    size = scene_size(with_points(frames, clip.points))
    return evaluated(model, frames, config.iterations, size, config.render_mode).psnr
