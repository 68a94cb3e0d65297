"""The training process: runs the steps, tells what happens, obeys single words between steps."""

from __future__ import annotations

import signal
import sys
import traceback
from collections.abc import Callable, Generator
from contextlib import closing, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Literal

import psutil

from app.console.ending import EndingSignals
from app.console.startup import rest_while_waiting
from app.errors import UserError, sentence
from app.runs.shared_model import Slot, SlotWriter
from app.runs.train_run import TrainRequest
from enhance import ImageError
from renderer.clip import ClipError
from renderer.train.events import Finished, Snapshot, TrainEvent, Warned

Steps = Callable[[TrainRequest], Generator[TrainEvent, None, None]]
"""`app.runs.train_run.run_training`, or what takes its place in tests: a function that can be imported."""
Word = Literal["pause", "resume", "cancel"]


@dataclass(frozen=True)
class Paused:
    """Training stands still until resumed or cancelled."""


@dataclass(frozen=True)
class Resumed:
    """Training goes on."""


@dataclass(frozen=True)
class Cancelled:
    """Training ended because it was asked to. By a word the steps done are kept, by SIGTERM the last
    checkpoint."""


@dataclass(frozen=True)
class Failed:
    """Training ended by itself before it was done; the last checkpoint is kept."""

    reason: str
    """One sentence for a person."""
    details: str = ""
    """The traceback when it is a bug."""


@dataclass(frozen=True)
class Ended:
    """Finished, without the model: that is in the run folder."""

    iteration: int
    seconds: float
    wall_seconds: float | None = None


def work(pipe: Connection, slot: Slot, steps: Steps, request: TrainRequest) -> None:
    """Run `steps` to their end, sending every small event; models go to the slot.

    Ends quietly, at its next step, when the process at the other end of the pipe is gone.
    """
    rest_while_waiting()
    # Ctrl+C in a terminal, and its end, reach both; the parent decides.
    for name in {"SIGINT", "SIGHUP"} & vars(signal).keys():
        signal.signal(getattr(signal, name), signal.SIG_IGN)
    psutil.Process().nice(psutil.BELOW_NORMAL_PRIORITY_CLASS if sys.platform == "win32" else 19)
    try:
        with EndingSignals():
            last = _run(pipe, SlotWriter(slot), steps, request)
    except KeyboardInterrupt:
        last = Cancelled()
    except (UserError, ClipError, ImageError) as error:
        last = Failed(str(error))
    except MemoryError:
        last = Failed("training ran out of memory: try fewer Gaussians or a smaller clip")
    except OSError as error:
        last = Failed(sentence(error), traceback.format_exc())
    except Exception as error:
        last = Failed(f"{type(error).__name__}: {error}", traceback.format_exc())
    with suppress(OSError):  # The process at the other end is gone.
        pipe.send(last)


def _run(
    pipe: Connection, models: SlotWriter, steps: Steps, request: TrainRequest
) -> Ended | Cancelled | Failed:
    is_told = False
    with closing(steps(request)) as events:
        for event in events:
            if isinstance(event, Finished):
                return Ended(event.iteration, event.seconds, event.wall_seconds)
            if isinstance(event, Snapshot):
                missing = _show(models, event)
                if missing and not is_told:
                    pipe.send(missing)
                    is_told = True
            else:
                pipe.send(event)
            if not _may_go_on(pipe):
                return Cancelled()
    return Failed("the training process ended before training was finished")


def _show(models: SlotWriter, snapshot: Snapshot) -> Warned | None:
    """Put its model in the slot; says so where it cannot be: training does not need it."""
    try:
        models.write(snapshot.model)
    except OSError as error:
        why = error.strerror or type(error).__name__
        return Warned(f"training goes on without a preview, for which shared memory has no room: {why}")
    return None


def _may_go_on(pipe: Connection) -> bool:
    """Obey the words that have come, waiting while paused; False when training shall end."""
    paused = False
    while paused or pipe.poll():
        word: Word = pipe.recv()
        if word == "cancel":
            return False
        if paused != (word == "pause"):
            paused = not paused
            pipe.send(Paused() if paused else Resumed())
    return True
