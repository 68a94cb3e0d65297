"""Training of a long clip in windows that overlap, one after the other."""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from renderer.atomic_files import written_atomically
from renderer.clip import Clip
from renderer.deformation.windowed_motion import LazyMotions, WindowedMotion, joined_rows
from renderer.gaussians import DynamicGaussians
from renderer.json_files import parsed
from renderer.near_plane import middle_distance
from renderer.stored_arrays import stored_metadata
from renderer.train.checkpoint import checkpoint_paths
from renderer.train.config import TrainConfig
from renderer.train.events import (
    Evaluated,
    Finished,
    Finishing,
    Omission,
    Progress,
    Snapshot,
    Started,
    TrainEvent,
    Warned,
)
from renderer.train.gradient_backend import GradientBackend
from renderer.train.held_out import evaluated
from renderer.train.trainer import TrainingError, fingerprint, split, train_window
from renderer.train.windows import Window, cut_notice, in_words

FOLDER: Final = "windows"
"""Of a run that is being trained: a folder for each, by number."""
MODEL: Final = "model.safetensors"
"""Of a window that is finished."""
STATE: Final = "state"
"""Of its metadata, as JSON."""


@dataclass(frozen=True)
class _Done:
    """A window of which all is done but its place among the others."""

    iterations: int
    seconds: float
    """Of its steps."""
    wall: float
    """Seconds in all; 0: an earlier part of the run did it."""
    omitted: tuple[Omission, ...]
    model: Callable[[], DynamicGaussians]


@dataclass(frozen=True)
class WindowedTraining:
    """Of one clip; see `renderer.train.training.train`."""

    clip: Clip
    config: TrainConfig
    windows: tuple[Window, ...]
    folder: Path | None
    resume: bool
    pictures: GradientBackend | None

    def events(self) -> Iterator[TrainEvent]:
        opened = time.perf_counter()
        if self.folder and not self.resume:
            shutil.rmtree(self.folder / FOLDER, ignore_errors=True)
        done: list[_Done] = []
        for number in range(len(self.windows)):
            done.append(self._kept(number) or (yield from self._trained(number, tuple(done))))
        model = self._joined(done)
        iteration = sum(each.iterations for each in done)
        if not any(each.wall for each in done):
            yield Started(iteration, iteration, len(model), ())
        yield Finishing("measuring held-out frames", 0.0)
        if measured := split(self.clip, self.config)[1] or self.clip.test_indices:
            views = (self.clip.read_frame(index) for index in measured)
            size = middle_distance(model, self.clip.cameras[0])
            yield evaluated(model, views, iteration, size, self.config.render_mode)
        seconds, wall = sum(each.seconds for each in done), time.perf_counter() - opened
        yield Finished(iteration, seconds, model, in_words([each.omitted for each in done]), wall)

    def _kept(self, number: int) -> _Done | None:
        """What an earlier part of the run finished. Raises TrainingError: another run did."""
        place = self._place(number)
        if place is None or not (place / MODEL).is_file():
            return None
        path = place / MODEL
        try:
            told = parsed(stored_metadata(path)[STATE])
            if told["fingerprint"] != fingerprint(self.windows[number].of(self.clip), self.config):
                raise TrainingError(
                    f"expected a window of this clip and configuration, got another: {place.name}"
                )
            iterations, seconds = int(told["iterations"]), float(told["seconds"])
        except (KeyError, TypeError, ValueError) as error:
            raise TrainingError(f"training cannot continue from the window ({error}): {path}") from error
        return _Done(iterations, seconds, 0.0, (), lambda: DynamicGaussians.load(path))

    def _trained(self, number: int, done: Sequence[_Done]) -> Generator[TrainEvent, None, _Done]:
        """The events of a window, as those of the whole clip, and what is left when it is finished."""
        began, place, window = time.perf_counter(), self._place(number), self.windows[number]
        clip = window.of(self.clip)
        resume = self.resume and place is not None and place.is_dir()
        omitted: tuple[Omission, ...] = ()
        for event in train_window(clip, self.config, folder=place, resume=resume, pictures=self.pictures):
            if isinstance(event, Finished):
                wall, omitted = time.perf_counter() - began, (*omitted, *event.omitted)
                model = self._stored(event, clip, place)
                return _Done(event.iteration, event.seconds, wall, omitted, model)
            if not isinstance(event, Started) or not any(each.wall for each in done):
                yield from self._as_of_all(event, done, window, began)
            if isinstance(event, Started):
                omitted = event.omitted
                if place is not None:
                    place.mkdir(parents=True, exist_ok=True)
        raise AssertionError("a training ends with Finished")

    def _as_of_all(
        self, event: TrainEvent, done: Sequence[_Done], window: Window, began: float
    ) -> Iterator[TrainEvent]:
        """An event of a window that began at `began`, after others that are done."""
        before, number = sum(each.iterations for each in done), len(self.windows)
        match event:
            case Started():
                total = event.iterations * number
                yield Started(before + event.iteration, total, event.n_gaussians, ())
                yield Warned(cut_notice(self.windows))
            case Progress():
                own = time.perf_counter() - began + event.seconds_left
                walls = [own, *(each.wall for each in done if each.wall)]
                later = (number - len(done) - 1) * float(np.mean(walls))
                yield replace(
                    event,
                    iteration=before + event.iteration,
                    iterations=event.iterations * number,
                    seconds=event.seconds + sum(each.seconds for each in done),
                    seconds_left=event.seconds_left + later,
                )
            case Snapshot():
                model = in_windows(len(self.clip), [window], [lambda: event.model])
                yield Snapshot(before + event.iteration, model)
            case Evaluated() if event.iteration < self.config.iterations:
                yield replace(event, iteration=before + event.iteration)
            case Warned():
                yield Warned(f"window {len(done) + 1}: {event.message}")

    def _place(self, number: int) -> Path | None:
        return None if self.folder is None else self.folder / FOLDER / f"{number:04d}"

    def _stored(self, event: Finished, clip: Clip, place: Path | None) -> Callable[[], DynamicGaussians]:
        """The model of a window, on the disk where there is a folder for it; its checkpoints go."""
        if place is None:
            return lambda: event.model
        path = place / MODEL
        told = {
            "fingerprint": fingerprint(clip, self.config),
            "iterations": event.iteration,
            "seconds": event.seconds,
        }
        with written_atomically(path) as partial:
            event.model.save(partial, {STATE: json.dumps(told)})
        for checkpoint in checkpoint_paths(place):
            checkpoint.unlink()
        return lambda: DynamicGaussians.load(path)

    def _joined(self, done: Sequence[_Done]) -> DynamicGaussians:
        return in_windows(len(self.clip), self.windows, [each.model for each in done])


def in_windows(
    count: int, windows: Sequence[Window], models: Sequence[Callable[[], DynamicGaussians]]
) -> DynamicGaussians:
    """Models of windows of a clip of `count` frames as one, which gets each of them when it is needed."""
    raws = [model().raw for model in models]
    rows = np.cumsum([0, *map(len, raws)]).astype(np.int64)
    frames = np.array([[window.first, window.last] for window in windows], np.int64)
    motions = LazyMotions(len(models), lambda window: models[window]().motion)
    return DynamicGaussians(joined_rows(raws), WindowedMotion(count, frames, rows, motions))
