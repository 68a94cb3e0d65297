"""A long clip in windows that overlap: each has Gaussians and a motion of its own, read when it is needed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, ClassVar, Final, Self, overload

import numpy as np
from numpy.typing import NDArray

from renderer.camera import IntArray
from renderer.deformation.kinds import motion_among
from renderer.deformation.motion import Motion
from renderer.raw_gaussians import RawGaussians, joined, logits, sigmoid
from renderer.stored_arrays import LazyArrays, Stored, check

HELD: Final = 3
"""Motions of windows that stay in memory: two that overlap, and one on the way there."""
FADE: Final = 1.0
"""Frames that a window takes to give way to the next one, between two of the clip, each of which shows one
window. Two together are less sharp: on a phantom 41.5 dB within overlaps, 42.8 with one, 42.4 elsewhere."""
FAINTEST: Final = 1e-6
"""Opacity of what is faded out, whose logarithm must be finite."""


class LazyMotions(Sequence[Motion]):
    """Of `count` windows; the last few that were asked for stay in memory."""

    def __init__(self, count: int, read: Callable[[int], Motion]) -> None:
        self._count, self._read = count, lru_cache(HELD)(read)

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, index: int) -> Motion: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Motion]: ...
    def __getitem__(self, index: int | slice) -> Motion | Sequence[Motion]:
        if isinstance(index, slice):
            return [self[place] for place in range(*index.indices(self._count))]
        return self._read(range(self._count)[index])


@dataclass(frozen=True, eq=False)
class WindowedMotion:
    """W windows in the order of time, each with the Gaussians of some rows: those of other windows are not
    there. A window overlaps none but its neighbours; about the middle of what two overlap the next one fades
    in, and then the one before fades out, so that nothing shines through."""

    NAMES: ClassVar[tuple[str, ...]] = ("window_clip", "window_frames", "window_fade", "window_rows")

    count: int
    """Frames of the clip."""
    frames: IntArray
    """(W, 2) first and last frame of each window."""
    first_rows: IntArray
    """(W + 1,) first Gaussian of each window, and the number of all."""
    motions: Sequence[Motion]
    """W of them; their time is that of their window."""
    fade: float | None = FADE
    """Frames that this takes; None: all of the overlap, as in models of before 0.14.0."""

    def __len__(self) -> int:
        return len(self.frames)

    def windows_at(self, time: float) -> tuple[int, ...]:
        """The window of a time in [0, 1], the one before or else after it where there is none, or the two
        that overlap there, in the order of time."""
        frame = self._frame(time)
        first, last = self.frames.T
        found = np.flatnonzero((first <= frame) & (frame <= last)).tolist()
        if len(found) == 2 and self.fade is not None:
            share = self._share_of_next(found[0], time)
            found = [one for one, seen in zip(found, (1 - share, share), strict=True) if seen > FAINTEST]
        before = int(np.searchsorted(first, frame, side="right")) - 1
        return tuple(found) or (max(before, 0),)

    def middle(self, window: int) -> float:
        """The frame, or the place between two, at which the next window begins to show more than this one."""
        both = int(self.frames[window + 1, 0] + self.frames[window, 1])
        return both / 2 if self.fade is None else both // 2 + 0.5

    def main_window_at(self, time: float) -> int:
        """The one that shows most at a time in [0, 1]: of two that overlap, up to the middle the former."""
        there = self.windows_at(time)
        return there[0] if len(there) == 1 or self._share_of_next(there[0], time) < 0.5 else there[1]

    def rows_at(self, time: float) -> IntArray:
        """Of `moved`: the Gaussians that there are at a time in [0, 1], ascending."""
        return np.concatenate([np.arange(*self._span(window)) for window in self.windows_at(time)])

    def moved(self, raw: RawGaussians, time: float) -> RawGaussians:
        """See Motion; only those that there are at `time`."""
        there = self.fades_at(time).items()
        return joined([faded(self._moved_in(raw, window, time), fade) for window, fade in there])

    def fades_at(self, time: float) -> dict[int, float]:
        """Of the windows that there are at a time in [0, 1], in the order of time, the share of their
        opacity that is seen."""
        there = self.windows_at(time)
        if len(there) == 1:
            return {there[0]: 1.0}
        share = self._share_of_next(there[0], time)
        return {there[0]: min(1.0, 2 * (1 - share)), there[1]: min(1.0, 2 * share)}

    def all_moved(self, raw: RawGaussians, time: float) -> RawGaussians:
        """Of all windows, each at the moment nearest to `time` in [0, 1] at which it is there."""
        return joined([self._moved_in(raw, window, time) for window in range(len(self))])

    def first_moved(self, raw: RawGaussians, time: float) -> RawGaussians:
        """Those that there are at `time`, at the first moment of their window."""
        return joined([self._moved_in(raw, window, 0.0) for window in self.windows_at(time)])

    def rows(self, index: NDArray[np.int64]) -> Self:
        """See Motion. Raises ValueError: the index is not in the order of the windows."""
        window_of = np.searchsorted(self.first_rows, index, side="right") - 1
        if (np.diff(window_of) < 0).any():
            raise ValueError("expected rows in the order of their windows")
        bounds = np.searchsorted(window_of, np.arange(len(self) + 1))

        def read(window: int) -> Motion:
            chosen = index[bounds[window] : bounds[window + 1]]
            return self.motions[window].rows(chosen - self.first_rows[window])

        return replace(self, first_rows=bounds.astype(np.int64), motions=LazyMotions(len(self), read))

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """Its own arrays, and those of the windows, which are read as they are asked for."""
        own: dict[str, NDArray[Any]] = {
            "window_clip": np.array([self.count], np.int64),
            "window_frames": self.frames,
            "window_rows": self.first_rows,
        }
        if self.fade is not None:
            own["window_fade"] = np.array([self.fade])
        names = [*own, *self._names()]

        def read(name: str) -> NDArray[Any]:
            if name in own:
                return own[name]
            window, _, of_motion = name.partition(".")
            return self.motions[int(window)].arrays()[of_motion]

        return LazyArrays(names, read)

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """See Motion; motions are read as they are needed."""
        frames = arrays["window_frames"]
        kinds = [_names_of(arrays, window) for window in range(len(frames))]

        def read(window: int) -> Motion:
            own = {name: arrays[f"{window}.{name}"] for name in kinds[window]}
            return motion_among(own).from_arrays(own)

        motions = LazyMotions(len(frames), read)
        fade = float(arrays["window_fade"][0]) if "window_fade" in arrays else None
        return cls(int(arrays["window_clip"][0]), frames, arrays["window_rows"], motions, fade)

    @classmethod
    def check(cls, arrays: Mapping[str, NDArray[Any]], count: int) -> None:
        """See Motion."""
        check(arrays, LAYOUT, {})
        rows, frames = arrays["window_rows"], arrays["window_frames"]
        n_frames = int(arrays["window_clip"][0])
        if len(rows) != len(frames) + 1 or rows[0] != 0 or rows[-1] != count or (np.diff(rows) < 0).any():
            raise ValueError(f"expected window_rows that share out {count} Gaussians, got others")
        first, last = frames.T
        in_order = (first[1:] > first[:-1]).all() and (last[1:] > last[:-1]).all() and (last >= first).all()
        whole = len(frames) > 0 and first[0] >= 0 and last[-1] < n_frames
        if not whole or not in_order or (first[2:] <= last[:-2]).any():
            raise ValueError("expected window_frames in order, none of which overlaps any but its neighbours")
        for window in range(len(frames)):
            own = {name: arrays[f"{window}.{name}"] for name in _names_of(arrays, window)}
            motion_among(own).check(own, int(rows[window + 1] - rows[window]))

    def _names(self) -> Iterator[str]:
        for window, motion in enumerate(self.motions):
            yield from (f"{window}.{name}" for name in motion.arrays())

    def _frame(self, time: float) -> float:
        return min(max(time, 0.0), 1.0) * self.count

    def _span(self, window: int) -> tuple[int, int]:
        return int(self.first_rows[window]), int(self.first_rows[window + 1])

    def _share_of_next(self, window: int, time: float) -> float:
        """How far a time is between a window and the next one, in [0, 1]."""
        start, end = self.frames[window + 1, 0], self.frames[window, 1]
        took = max(end - start, 1) if self.fade is None else self.fade
        return float(np.clip((self._frame(time) - self.middle(window)) / took + 0.5, 0, 1))

    def _moved_in(self, raw: RawGaussians, window: int, time: float) -> RawGaussians:
        if self.first_rows[-1] != len(raw):
            raise ValueError(f"expected a motion of {len(raw)} Gaussians, got one of {self.first_rows[-1]}")
        first, last = self.frames[window]
        start, end = self._span(window)
        of_window = RawGaussians(**{name: value[start:end] for name, value in raw.arrays().items()})
        local = (self._frame(time) - first) / (last - first + 1)
        return self.motions[window].moved(of_window, min(max(float(local), 0.0), 1.0))


def faded(raw: RawGaussians, share: float) -> RawGaussians:
    """With opacities times `share` in [0, 1]."""
    if share >= 1:
        return raw
    opacities = np.clip(share * sigmoid(raw.opacity_logits), np.float32(FAINTEST), None)
    return replace(raw, opacity_logits=logits(opacities))


def _names_of(arrays: Mapping[str, NDArray[Any]], window: int) -> tuple[str, ...]:
    prefix = f"{window}."
    return tuple(name.removeprefix(prefix) for name in arrays if name.startswith(prefix))


LAYOUT = {
    "window_clip": Stored("1", np.int64, least=1),
    "window_frames": Stored("W 2", np.int64, least=0),
    "window_fade": Stored("1", np.float64, least=1e-3, optional=True),
    "window_rows": Stored("R", np.int64, least=0),
}
