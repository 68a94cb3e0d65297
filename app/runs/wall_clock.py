"""How long a run takes in all, beside the seconds of its steps."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import closing
from time import perf_counter
from typing import Final, TypeVar

Event = TypeVar("Event")

STEPS: Final = "seconds of training steps alone, summed over all parts of an interrupted run"
WALL: Final = (
    "seconds of all work on the run: reading and analysing the clip, compiling kernels, steps, checkpoints, "
    "previews, held-out frames and writing the model, summed over all parts of an interrupted run; without "
    "pauses, and without the start of the program itself; null: not recorded, by an earlier version"
)
"""What `train_seconds` and `wall_seconds` are."""


class WallClock:
    """Runs from when it is made; `before`: seconds of earlier parts, None where nobody knows them."""

    def __init__(self, before: float | None = 0.0) -> None:
        self.before = before
        self._worked, self._since = 0.0, perf_counter()

    def seconds(self) -> float | None:
        """So far; None: not known."""
        now = self._worked + perf_counter() - self._since
        return None if self.before is None else self.before + now

    def over(self, events: Generator[Event, None, None]) -> Generator[Event, None, None]:
        """The same events. While whoever takes them keeps one, as during a pause, the clock stands."""
        with closing(events):
            for event in events:
                self._worked += perf_counter() - self._since
                yield event
                self._since = perf_counter()


def in_all(wall: float | None, steps: float | None, form: str = ".1f") -> str:
    """Both times in words, as far as they are recorded: "7.7 s in total, 1.4 s training"."""
    times = ((wall, "in total"), (steps, "training"))
    return ", ".join(f"{time:{form}} s {of}" for time, of in times if time is not None) or "not recorded"
