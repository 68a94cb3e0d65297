"""A training run in a process of its own: started, watched, paused and ended by the window.

The process is spawned, so that neither torch nor a crash of the training reaches the window. Both ends
talk over one pipe: events come, single words go. A pipe holds no lock that a killed process could take
with it, and its end of file tells each side that the other is gone.
"""

from __future__ import annotations

import multiprocessing
import signal
import threading
from collections.abc import Mapping
from contextlib import suppress
from queue import SimpleQueue
from typing import Final, Literal

from app.console.ending import unheard
from app.errors import sentence
from app.runs.run_folder import RunFolder
from app.runs.shared_model import Slot, SlotReader
from app.runs.train_run import TrainRequest, run_training
from app.runs.worker import Cancelled, Ended, Failed, Paused, Resumed, Steps, Word, work
from renderer.gaussians import DynamicGaussians
from renderer.train.events import (
    Evaluated,
    Finished,
    Finishing,
    Planned,
    Preparing,
    Progress,
    Started,
    Warned,
)

__all__ = ["Cancelled", "Failed", "JobEvent", "Paused", "Resumed", "State", "TrainingJob"]

State = Literal["new", "running", "paused", "finished", "cancelled", "failed"]
Ending = Finished | Cancelled | Failed
JobEvent = (
    Preparing | Planned | Started | Progress | Evaluated | Finishing | Warned | Paused | Resumed | Ending
)
STATE_AFTER: Final[Mapping[type, State]] = {
    Paused: "paused",
    Resumed: "running",
    Finished: "finished",
    Cancelled: "cancelled",
    Failed: "failed",
}
"""Of a job, by the event; after any other it stays."""

SECONDS_TO_END = 5.0
"""How long the process may take to end by itself when the job is closed: it writes a checkpoint."""


class TrainingJob:
    """One training run, from `start` to exactly one of Finished, Cancelled and Failed.

    All methods are for one thread and none of them waits, but for `close`.
    """

    def __init__(self, request: TrainRequest, steps: Steps = run_training) -> None:
        context = multiprocessing.get_context("spawn")
        slot = Slot.make(context)
        self.request = request
        self.state: State = "new"
        self._pipe, self._far_end = context.Pipe()
        self._process = context.Process(target=work, args=(self._far_end, slot, steps, request), daemon=True)
        self._reader = SlotReader(slot)
        self._inbox: SimpleQueue[JobEvent] = SimpleQueue()
        self._listener = threading.Thread(target=self._listen, daemon=True)

    def start(self) -> None:
        """Start the process. A job starts once."""
        with unheard():
            self._process.start()
        self._far_end.close()
        self._listener.start()
        self.state = "running"

    def poll(self) -> list[JobEvent]:
        """What happened since the last call, oldest first; `state` follows it."""
        events = [self._inbox.get() for _ in range(self._inbox.qsize())]
        for event in events:
            self.state = STATE_AFTER.get(type(event), self.state)
        return events

    @property
    def has_gone(self) -> bool:
        """Its process has ended, so that `close` waits for nothing."""
        return not self._process.is_alive()

    def latest_model(self) -> DynamicGaussians | None:
        """The newest snapshot; the same object until there is a newer one. None before the first."""
        return self._reader.newest()

    def pause(self) -> None:
        """Ask to stand still; `Paused` comes when it does."""
        self._say("pause")

    def resume(self) -> None:
        """Ask to go on after a pause; `Resumed` comes when it does."""
        self._say("resume")

    def cancel(self) -> None:
        """Ask to end, also while paused; `Cancelled` comes when it has. The steps done are kept."""
        self._say("cancel")

    def close(self) -> None:
        """End the process, waiting at most a few seconds, and give back the shared memory."""
        if self._process.pid is not None:
            # One that has told its end closes its pipe before it goes, and to write to that can be a signal.
            if self.state in ("running", "paused"):
                self.cancel()
            self._process.join(SECONDS_TO_END)
            for end in (self._process.terminate, self._process.kill):
                if self._process.is_alive():
                    end()
                    self._process.join(SECONDS_TO_END)
            self._listener.join()
        self._pipe.close()
        self._far_end.close()
        self._reader.close()

    def _say(self, word: Word) -> None:
        # A process that is gone has nothing to obey; the listener tells how it ended.
        with suppress(OSError):
            self._pipe.send(word)

    def _listen(self) -> None:
        """Take events as they come, so that the process never waits for the window."""
        last: JobEvent | Ended | None = None
        with suppress(EOFError, OSError):
            while True:
                last = received = self._pipe.recv()
                self._inbox.put(self._with_model(received) if isinstance(received, Ended) else received)
        self._process.join()
        if not isinstance(last, Ended | Cancelled | Failed):
            kept = RunFolder(self.request.run_path).has_checkpoint
            self._inbox.put(Failed(_death(self._process.exitcode, kept=kept)))

    def _with_model(self, ended: Ended) -> Finished | Failed:
        path = RunFolder(self.request.run_path).model_path
        try:
            model = DynamicGaussians.load(path)
            return Finished(ended.iteration, ended.seconds, model, wall_seconds=ended.wall_seconds)
        except (ValueError, MemoryError) as error:
            return Failed(sentence(error))


def _death(exit_code: int | None, *, kept: bool) -> str:
    """How the process ended that did not say so itself, and whether it left a checkpoint."""
    left = "the last checkpoint is kept" if kept else "there is no checkpoint"
    if exit_code is not None and exit_code < 0:
        # Those of real time have no names.
        name = next((one.name for one in signal.Signals if one == -exit_code), f"signal {-exit_code}")
        cause = " (often: out of memory)" if name == "SIGKILL" else ""
        return f"the training process was killed by {name}{cause}; {left}"
    return f"the training process ended with exit code {exit_code} before training was finished; {left}"
