"""The one-time preparation in a process of its own: numba holds up all threads of one that compiles.

What it compiles lies on disk, where the window and the training find it. It ends with the process that
started it, however that ends.
"""

from __future__ import annotations

import math
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Final

import psutil

from app.console.ending import unheard
from app.console.startup import rest_while_waiting
from app.kernels.progress import Kind, Preparation, tasks

SECONDS_TO_END: Final = 2.0
NICE: Final = 5
"""Once the first step is done, which a person waits for; then what is done in the window comes first."""


class Preparer:
    """One preparation. All methods are for one thread, and none of them waits, but for `close`."""

    def __init__(self, *first: Kind) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, self._far_end = context.Pipe()
        self._process = context.Process(target=work, args=(self._far_end, *first), daemon=True)
        self._newest = Preparation(tasks(*first))
        self._since = time.monotonic()
        self._best_end = math.inf
        """When it should be complete, by the best that was expected so far."""

    def start(self) -> None:
        with unheard():
            self._process.start()
        self._far_end.close()

    def poll(self) -> Preparation | None:
        """How far it is; None once it has ended, in whatever way."""
        with suppress(OSError):
            try:
                while self._pipe.poll():
                    self._newest, self._since = self._pipe.recv(), time.monotonic()
            except EOFError:
                self.close()
        if self._pipe.closed:
            return None
        now = time.monotonic()
        newest = replace(self._newest, seconds=now - self._since)
        end = now + newest.seconds_left
        self._best_end = min(self._best_end, end)
        return replace(newest, late=end - self._best_end)

    @property
    def is_complete(self) -> bool:
        return self._newest.is_ready

    def close(self) -> None:
        """End the process; what it has compiled stays. At most a few seconds."""
        self._pipe.close()
        self._far_end.close()
        if self._process.pid is not None:
            _end(self._process)


@contextmanager
def taken_beside(kinds: Sequence[Kind]) -> Iterator[Callable[[], None]]:
    """A second process takes the steps of these kinds meanwhile; what is yielded waits until it has."""
    context = multiprocessing.get_context("spawn")
    pipe, far_end = context.Pipe()
    process = context.Process(target=take, args=(far_end, kinds), daemon=True)
    with unheard():
        process.start()
    far_end.close()
    try:
        yield process.join
    finally:
        pipe.close()
        _end(process)


def _end(process: BaseProcess) -> None:
    for end in (process.terminate, process.kill):
        if process.is_alive():
            end()
            process.join(SECONDS_TO_END)


def take(pipe: Connection, kinds: Sequence[Kind]) -> None:
    """In the second process."""
    _begin(pipe)
    from app.kernels.steps import use

    for task in tasks():
        if task.kind in kinds:
            use(task)


def _begin(pipe: Connection) -> None:
    """In a process that compiles: it ends with the one that started it, and by nothing else."""
    rest_while_waiting()
    for name in {"SIGINT", "SIGHUP"} & vars(signal).keys():
        signal.signal(getattr(signal, name), signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(pipe,), daemon=True).start()


def work(pipe: Connection, *first: Kind) -> None:
    """In the process: prepare, and say how far it is before each step."""
    _begin(pipe)
    # Loaded in this process only.
    from app.kernels.steps import prepare

    with suppress(BrokenPipeError):
        for now in prepare(*first):
            if now.done == 1:
                psutil.Process().nice(psutil.BELOW_NORMAL_PRIORITY_CLASS if sys.platform == "win32" else NICE)
            pipe.send(now)


def _end_with(pipe: Connection) -> None:
    """Nothing is ever sent this way: the end of file tells that nobody is there any more. Kernels appear on
    disk complete or not at all."""
    with suppress(EOFError, OSError):
        pipe.recv()
    os._exit(0)
