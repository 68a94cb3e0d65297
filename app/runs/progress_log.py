"""What a run has said of its progress, from events.jsonl: for the curves."""

from __future__ import annotations

from dataclasses import MISSING, dataclass, fields, replace
from math import inf, nan
from typing import Any, Final, TypeVar

from app.runs.run_folder import RunFolder, is_number, wall_seconds_of
from renderer.train.events import Evaluated, Progress

Event = TypeVar("Event", Progress, Evaluated)


@dataclass(frozen=True)
class TrainingLog:
    """What a run has logged in all of its processes, oldest first."""

    progress: tuple[Progress, ...] = ()
    evaluated: tuple[Evaluated, ...] = ()

    def steps(self, asked: int) -> int:
        """That the run takes: methods with a stage of their own before, and windows, take more than `asked`,
        which is the answer where nothing was said."""
        return self.progress[-1].iterations if self.progress else asked

    def until(self, iteration: int) -> TrainingLog:
        """Without what is done again by a run that goes on from there."""
        return TrainingLog(
            tuple(event for event in self.progress if event.iteration <= iteration),
            tuple(event for event in self.evaluated if event.iteration <= iteration),
        )


EMPTY_LOG: Final = TrainingLog()


def told(folder: RunFolder) -> TrainingLog:
    """Lines of other versions are taken where they have what is needed, else passed over.

    Of steps that a run has done again, from a checkpoint, the last time counts.

    What came after the last step took its time, too: the last of the progress tells it.
    """
    events = folder.events()
    lasting = _lasting(events)
    progress = _of(Progress, lasting)
    last = tuple(replace(one, wall_seconds=wall_seconds_of(events)) for one in progress[-1:])
    return TrainingLog((*progress[:-1], *last), _of(Evaluated, lasting))


def _lasting(events: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Those of steps that a later start did not go back behind."""
    kept, least = list[dict[str, Any]](), inf
    for event in reversed(events):
        iteration = event.get("iteration")
        if not is_number(iteration) or iteration <= least:
            kept.append(event)
        if event["event"] == "Started" and is_number(iteration):
            least = min(least, iteration)
    return kept[::-1]


def _of(kind: type[Event], events: list[dict[str, Any]]) -> tuple[Event, ...]:
    """Those of one kind; what is no number, such as the null of an infinite one, counts as missing, but for
    the PSNR of frames in which nothing is evaluated."""
    known, found = {item.name: item for item in fields(kind)}, []
    for event in events:
        if event["event"] != kind.__name__:
            continue
        values = {name: value for name, value in event.items() if name in known and is_number(value)}
        if kind is Evaluated and event.get("psnr", nan) is None:
            values["psnr"] = nan
        if all(name in values or item.default is not MISSING for name, item in known.items()):
            found.append(kind(**values))
    return tuple(found)
