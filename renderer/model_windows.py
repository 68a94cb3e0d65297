"""A model by its windows, each with a clock of its own; one that is not cut is one window."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, floor

import numpy as np
from numpy.typing import NDArray

from renderer.deformation.windowed_motion import WindowedMotion, faded
from renderer.gaussians import DynamicGaussians
from renderer.raw_gaussians import RawGaussians
from renderer.splats import Splats


@dataclass(frozen=True, eq=False)
class ModelWindow:
    """Some of the Gaussians of a model: those that are there in a part of its clip."""

    whole: DynamicGaussians
    index: int
    """Of it among the windows."""
    start: float
    """Its first moment as a time of the clip, in [0, 1]."""
    length: float
    """Of its part of the clip, in (0, 1]."""

    def __len__(self) -> int:
        return int(self.rows.stop - self.rows.start)

    @property
    def rows(self) -> slice:
        """Of the whole model."""
        first, end = _cut(self.whole).first_rows[self.index : self.index + 2]
        return slice(int(first), int(end))

    @property
    def model(self) -> DynamicGaussians:
        """Its Gaussians, which move by its own clock."""
        if not isinstance(motion := self.whole.motion, WindowedMotion):
            return self.whole
        raw = {name: value[self.rows] for name, value in self.whole.raw.arrays().items()}
        return DynamicGaussians(RawGaussians(**raw), motion.motions[self.index])

    def frames(self, count: int) -> range:
        """Its own among those of the clip, which has so many."""
        return range(round(self.start * count), round((self.start + self.length) * count))

    def seen_frames(self, count: int) -> range:
        """Those of its frames that show it; in models of before 0.14.0 all, at the ends of some hardly."""
        frames, shown = self.frames(count), self.shown
        if shown is None:
            return frames
        return range(max(frames.start, floor(shown[0]) + 1), min(frames.stop, ceil(shown[1])))

    @property
    def shown(self) -> tuple[float, float] | None:
        """Between which frames, or places between two, of the clip any of it is seen, beyond the clip's ends
        where it is the first or last. None: wherever it is, as in models of before 0.14.0."""
        motion = self.whole.motion
        if not isinstance(motion, WindowedMotion) or motion.fade is None:
            return None
        first, last = motion.frames[self.index].tolist()
        is_last = self.index == len(motion) - 1
        begin = motion.middle(self.index - 1) - motion.fade / 2 if self.index else first - 1
        return begin, last + 1 if is_last else motion.middle(self.index) + motion.fade / 2

    def local(self, time: float) -> float:
        """By its clock, in [0, 1]; its first or last moment before or after it."""
        return min(max((time - self.start) / self.length, 0.0), 1.0)

    def seen(self, model: DynamicGaussians, time: float) -> RawGaussians:
        """Those of its `model` at a time of the clip, as much of them as is seen there."""
        return faded(model.motion.moved(model.raw, self.local(time)), self.fade(time))

    def fade(self, time: float) -> float:
        """The share of its opacity, in [0, 1], that is seen at a time of the clip."""
        return _cut(self.whole).fades_at(time).get(self.index, 0.0)

    def time(self, local: float) -> float:
        """Of the clip."""
        return self.start + local * self.length


def windows_of(model: DynamicGaussians) -> tuple[ModelWindow, ...]:
    """In the order of time; their rows follow each other."""
    motion = _cut(model)
    starts, lengths = motion.frames[:, 0] / motion.count, (np.diff(motion.frames)[:, 0] + 1) / motion.count
    return tuple(
        ModelWindow(model, index, float(start), float(length))
        for index, (start, length) in enumerate(zip(starts, lengths, strict=True))
    )


def window_at(model: DynamicGaussians, time: float) -> ModelWindow:
    """The one that shows most of the model at a time in [0, 1]."""
    return windows_of(model)[_cut(model).main_window_at(time)]


def handover(former: ModelWindow) -> float:
    """The time in [0, 1] from which the next window, of which there is one, shows more than this one."""
    motion = _cut(former.whole)
    return motion.middle(former.index) / motion.count


def whole_at(model: DynamicGaussians, time: float) -> Splats:
    """All of its Gaussians, each at the moment nearest to `time` in [0, 1] at which it is there."""
    return _cut(model).all_moved(model.raw, time).splats()


def first_at(model: DynamicGaussians, time: float) -> Splats:
    """Those that are drawn at a time in [0, 1], at the first moment of the clip or of their window."""
    return _cut(model).first_moved(model.raw, time).splats()


def there_at(model: DynamicGaussians, time: float) -> NDArray[np.bool_]:
    """(N,) which of its Gaussians are drawn at a time in [0, 1]."""
    there = np.zeros(len(model), np.bool_)
    there[_cut(model).rows_at(time)] = True
    return there


def _cut(model: DynamicGaussians) -> WindowedMotion:
    """Its motion; of a model that is not cut, as that of one window."""
    if isinstance(model.motion, WindowedMotion):
        return model.motion
    return WindowedMotion(1, np.zeros((1, 2), np.int64), np.array([0, len(model)]), (model.motion,))
