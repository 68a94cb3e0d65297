"""Training of a long clip in windows that overlap, one after the other."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from renderer.clip import Clip
from renderer.deformation.motion import Still
from renderer.gaussians import DynamicGaussians
from renderer.near_plane import middle_distance
from renderer.raw_gaussians import RawGaussians
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
from renderer.train.fingerprint import fingerprint, former_fingerprint
from renderer.train.frames import as_fitted
from renderer.train.gradient_backend import GradientBackend
from renderer.train.held_out import evaluated
from renderer.train.initialize import NoTissue
from renderer.train.trainer import MEASURING, TrainingError, fitted, split, train_window
from renderer.train.window_files import (
    FinishedWindow,
    finish,
    finished,
    folder_of,
    in_windows,
    is_finished,
    load,
)
from renderer.train.windows import Window, cut_notice, in_words


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
    missing: NoTissue | None = None
    """Why there is nothing in it."""


def _nothing() -> DynamicGaussians:
    empty, harmonics = np.zeros((0, 3), np.float32), np.zeros((0, 0, 3), np.float32)
    quats, logits = np.zeros((0, 4), np.float32), np.zeros(0, np.float32)
    return DynamicGaussians(RawGaussians(empty, quats, empty, logits, empty, harmonics), Still())


@dataclass(frozen=True)
class WindowedTraining:
    """Of one clip; see `renderer.train.training.train`."""

    clip: Clip
    config: TrainConfig
    windows: tuple[Window, ...]
    folder: Path | None
    resume: bool
    pictures: GradientBackend | None

    def events(self) -> Generator[TrainEvent, None, None]:
        opened = time.perf_counter()
        done: list[_Done] = []
        for window in self.windows:
            try:
                done.append(self._kept(window) or (yield from self._trained(window, tuple(done))))
            except NoTissue as error:  # As out of the body: of long clips the rest is worth it.
                done.append(_Done(0, 0.0, 0.0, (), _nothing, error))
        if all(missing := [each.missing for each in done]) and missing[0] is not None:
            raise missing[0]
        model = in_windows(len(self.clip), self.windows, [each.model for each in done])
        iteration = sum(each.iterations for each in done)
        if not any(each.wall for each in done):
            yield Started(iteration, iteration, len(model), ())
        for window, each in zip(self.windows, done, strict=True):
            if each.missing is not None:
                first, last = self.clip.labels[window.first], self.clip.labels[window.last]
                what = "they show no tissue of known depth"
                yield Warned(f"nothing is reconstructed of the frames {first} to {last}: {what}")
        yield Finishing(MEASURING, 0.0)
        if measured := self._held_out if self.config.hold_out else self.clip.test_indices:
            views = (self.clip.read_frame(index) for index in measured)
            size = middle_distance(model, self.clip.cameras[0])
            yield evaluated(model, views, iteration, size, self.config.render_mode)
        seconds, wall = sum(each.seconds for each in done), time.perf_counter() - opened
        yield Finished(iteration, seconds, model, in_words([each.omitted for each in done]), wall)

    @property
    def _held_out(self) -> tuple[int, ...]:
        """Of the whole clip: frames that two windows share are held out of both or of neither."""
        return split(self.clip, self.config)[1]

    def _kept(self, window: Window) -> _Done | None:
        """What an earlier part of the run finished. Raises TrainingError: another run did."""
        if self.folder is None or not self.resume:
            return None
        if not is_finished(folder := folder_of(self.folder, window)):
            return None
        try:
            told = finished(folder)
        except ValueError as error:
            raise TrainingError(f"training cannot continue ({error})") from error
        former = former_fingerprint(window.of(self.clip), self.config)
        if told.fingerprint not in (former, self._fingerprint(window)):
            wanted = "expected a window of this clip and configuration"
            raise TrainingError(f"{wanted}, got another: {folder.name}")
        return _Done(told.iterations, told.seconds, 0.0, told.omitted, lambda: load(folder))

    def _trained(self, window: Window, done: Sequence[_Done]) -> Generator[TrainEvent, None, _Done]:
        """The events of a window, as those of the whole clip, and what is left when it is finished."""
        began, clip = time.perf_counter(), window.of(self.clip)
        folder = folder_of(self.folder, window) if self.folder else None
        resume = self.resume and folder is not None and folder.is_dir()
        omitted, steps = tuple[Omission, ...](), 0
        training = train_window(
            clip, self.config, window.inside(self._held_out), folder=folder, resume=resume,
            pictures=self.pictures,
        )  # fmt: skip
        with closing(training) as events:
            for event in events:
                match event:
                    case Finished():
                        wall, omitted = time.perf_counter() - began, (*omitted, *event.omitted)
                        model = self._stored(event, window, omitted, folder)
                        return _Done(event.iteration, event.seconds, wall, omitted, model)
                    case Started():
                        omitted, steps = event.omitted, event.iterations
                        if not any(each.wall for each in done):
                            yield from self._as_of_all(event, done, window, began)
                        if folder is not None:
                            folder.mkdir(parents=True, exist_ok=True)
                    case Evaluated() if event.iteration == steps:
                        pass  # In the end all of the clip is measured.
                    case _:
                        yield from self._as_of_all(event, done, window, began)
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
            case Evaluated():
                yield replace(event, iteration=before + event.iteration)
            case Warned():
                yield Warned(f"window {len(done) + 1}: {event.message}")

    def _stored(
        self, event: Finished, window: Window, omitted: tuple[Omission, ...], folder: Path | None
    ) -> Callable[[], DynamicGaussians]:
        """The model of a window, on the disk where there is a folder for it."""
        if folder is None:
            return lambda: event.model
        told = FinishedWindow(self._fingerprint(window), event.iteration, event.seconds, omitted)
        finish(folder, event.model, told)
        return lambda: load(folder)

    def _fingerprint(self, window: Window) -> str:
        """As its checkpoints have it. Raises ClipError: its first frame cannot be read."""
        clip = window.of(self.clip)
        fit = fitted(clip, window.inside(self._held_out))
        return fingerprint(clip, self.config, fit, as_fitted(clip.read_frame(fit[0])))
