"""How far the one-time preparation is: which step, of how many, what is ready, and the time left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, get_args

from app.enhancement.methods import PAPER, VESSEL, Preset
from renderer.train.config import Method

Kind = Preset | Literal["3D view", "training", "16 bits"]
"""What can be used once its steps are done."""
SECONDS: Final[Mapping[str, float]] = {
    VESSEL: 25,
    PAPER: 2,
    "3D view": 4,
    "vesselsplat": 25,
    "deform3dgs": 6,
    "endogaussian": 12,
    "static": 1,
}
"""About how long each step takes on an ordinary computer."""
SHARED: Final = 35.0
"""More of the first of the two methods, for what both have in common."""
DRAWING: Final = 12.0
"""Of the own training, what the 3D view has in common with it and takes itself where it comes first."""
DEEP: Final = ", 16 bits"
OVER: Final = 0.25
"""Of a step that takes longer than it should, what is still to come, as a share of its time so far."""
LATE: Final = 10.0
"""Seconds by which the time left may grow before that is said."""
QUICK: Final = 0.2
"""Share of the usual time below which a step had been prepared before, and tells nothing of this computer."""


@dataclass(frozen=True)
class Task:
    """One step: a feature, used once."""

    name: str
    kind: Kind
    seconds: float
    """About how long it takes on an ordinary computer."""


def tasks(*first: Kind) -> tuple[Task, ...]:
    """In the order of need: those of the kinds that are wanted `first`, then the others."""
    presets: tuple[Preset, ...] = (PAPER, VESSEL) if PAPER in first else (VESSEL, PAPER)
    cost = dict(SECONDS)
    cost[presets[0]] += SHARED
    if "3D view" in first:
        cost |= {"3D view": cost["3D view"] + DRAWING, "vesselsplat": cost["vesselsplat"] - DRAWING}
    own, *published = [Task(method, "training", cost[method]) for method in get_args(Method)]
    eight = [Task(preset, preset, cost[preset]) for preset in presets]
    deep = [Task(f"{preset}{DEEP}", "16 bits", cost[preset]) for preset in presets]
    usual = (*eight, own, Task("3D view", "3D view", cost["3D view"]), *published, *deep)
    return tuple(sorted(usual, key=lambda task: (*first, task.kind).index(task.kind)))


@dataclass(frozen=True)
class Preparation:
    """After `done` of `tasks`; crosses to the window by value."""

    tasks: tuple[Task, ...]
    done: int = 0
    pace: float = 1.0
    """Seconds here for each of an ordinary computer."""
    seconds: float = 0.0
    """Since the step under way began."""
    late: float = 0.0
    """Seconds by which the end is later than it was expected at the best."""

    @property
    def is_ready(self) -> bool:
        return self.done == len(self.tasks)

    @property
    def step(self) -> int:
        """The step under way, counted from 1; the last one at the end."""
        return min(self.done + 1, len(self.tasks))

    @property
    def name(self) -> str:
        return self.tasks[self.step - 1].name

    def has(self, kind: Kind) -> bool:
        """Nothing of this kind is still to be prepared."""
        return all(task.kind != kind for task in self.tasks[self.done :])

    @property
    def seconds_left(self) -> float:
        return self._seconds(len(self.tasks))

    def seconds_until(self, kind: Kind) -> float:
        """Until all of this kind is prepared."""
        return self._seconds(max(place for place, task in enumerate(self.tasks, 1) if task.kind == kind))

    def left(self, kind: Kind | None = None) -> str:
        """The time until all of it is prepared, or all of this kind, in words."""
        longer = "longer than expected, " if self.late > LATE else ""
        return f"{longer}{rounded(self.seconds_left if kind is None else self.seconds_until(kind))} left"

    def _seconds(self, end: int) -> float:
        todo = self.tasks[self.done : end]
        if not todo:
            return 0.0
        # A step that takes longer than it should tells of this computer before it has ended.
        pace = max(self.pace, self.seconds / todo[0].seconds)
        under_way = max(pace * todo[0].seconds - self.seconds, OVER * self.seconds)
        return under_way + pace * sum(task.seconds for task in todo[1:])


def paced(tasks: Sequence[Task], taken: Sequence[float]) -> float:
    """Seconds here for each of an ordinary computer, by the steps that have taken so long."""
    told = [
        (seconds, task.seconds)
        for task, seconds in zip(tasks, taken, strict=False)
        if seconds > QUICK * task.seconds
    ]
    return sum(seconds for seconds, _ in told) / sum(usual for _, usual in told) if told else 1.0


def worded(now: Preparation) -> str:
    """In a line, as the window and the command say it."""
    return f"One-time preparation, step {now.step} of {len(now.tasks)} · {now.left()}"


def rounded(seconds: float) -> str:
    """A time left in words, no more exact than such an estimate is."""
    if seconds < 10:
        return "a few seconds"
    if seconds < 100:
        return f"about {10 * round(seconds / 10)} s"
    return f"about {round(seconds / 60)} min" if seconds < 6000 else f"about {round(seconds / 3600)} h"
