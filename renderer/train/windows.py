"""The windows that a long clip is cut into, each with Gaussians and curves of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import Final

from renderer.clip import Clip
from renderer.train.config import TrainConfig
from renderer.train.events import Omission

OVERLAP: Final = 16
"""Frames that two windows share, in which one fades into the next."""
ALIGNED: Final = 8
"""Windows begin at multiples of this, so that the same frames are held out as of the whole clip."""
SHORTEST: Final = 3 * OVERLAP
"""Frames of a window: it overlaps none but its neighbours."""
LONGEST: Final = 400
"""Frames of a window where nobody says."""


@dataclass(frozen=True)
class Window:
    """Frames of a clip, both included, counted from 0."""

    first: int
    last: int

    def __len__(self) -> int:
        return self.last - self.first + 1

    def of(self, clip: Clip) -> Clip:
        """As a clip of its own, numbered and timed anew; the clip itself where that is all of it."""
        return clip if len(self) == len(clip) else clip.between(self.first, self.last)


def windows_of(clip: Clip, config: TrainConfig) -> tuple[Window, ...]:
    """Of nearly equal length, in the order of time; a single one where the clip is short enough."""
    return cut(len(clip), config.window_frames or LONGEST)


def cut(count: int, longest: int) -> tuple[Window, ...]:
    """`count` frames in windows of at most about `longest`."""
    if count <= longest:
        return (Window(0, count - 1),)
    number = ceil((count - OVERLAP) / (longest - OVERLAP))
    step = ALIGNED * ceil((count - OVERLAP) / number / ALIGNED)
    starts = range(0, count - OVERLAP, step)
    return tuple(Window(start, min(start + step + OVERLAP, count) - 1) for start in starts)


def cut_notice(windows: tuple[Window, ...]) -> str:
    """What is said of a clip in several windows."""
    longest = max(map(len, windows))
    return (
        f"the clip is reconstructed in {len(windows)} windows of up to {longest} frames, each with Gaussians "
        f"of its own; neighbours share {OVERLAP} frames, in which one fades into the next"
    )


def left_out(clip: Clip, config: TrainConfig) -> tuple[Omission, ...]:
    """Other windows, where one is enough for the clip."""
    if len(windows_of(clip, config)) > 1:
        return ()
    longest = config.window_frames or LONGEST
    why = f"the clip has {len(clip)} frames, and windows are for more than {longest}"
    return (Omission("windows", why, "Gaussians and curves for each window"),)


def in_words(omitted: Sequence[Sequence[Omission]]) -> tuple[Omission, ...]:
    """What each of the windows does without, told once: as of the first that does."""
    merged: dict[str, Omission] = {}
    for number, of_window in enumerate(omitted, start=1):
        for one in of_window:
            merged.setdefault(one.what, replace(one, why=f"{one.why} (window {number})"))
    return tuple(merged.values())
