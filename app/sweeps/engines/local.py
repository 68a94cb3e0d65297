"""Processes on this machine."""

from __future__ import annotations

import multiprocessing
import signal
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any

from app.console.ending import unheard
from app.console.startup import rest_while_waiting
from app.sweeps.engines.engine import Engine, workers_for
from app.sweeps.worker import end_with_parent

AHEAD = 2
"""Jobs that wait beside those that run, so that no worker does."""
MOST_ON_WINDOWS = 61
"""Processes of a pool: Python waits there for no more at once."""


@contextmanager
def local(workers: int | None, threads: int) -> Iterator[Engine]:
    """As many workers as there are cores for `threads` each, unless told otherwise."""
    count = workers or workers_for(threads)
    if sys.platform == "win32":
        count = min(count, MOST_ON_WINDOWS)
    executor = Processes(count)
    try:
        yield Engine("local", executor, count, count + AHEAD, shares_fate=True)
    finally:
        executor.end()


class Processes(Executor):
    """A pool of processes that is replaced when one of them was killed; its pending jobs then fail with
    BrokenExecutor, and can be submitted again."""

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._pool = self._new()

    def _new(self) -> ProcessPoolExecutor:
        context = multiprocessing.get_context("spawn")
        return ProcessPoolExecutor(self._workers, context, _begin)

    def submit(self, function: Callable[..., Any], /, *given: Any, **named: Any) -> Future[Any]:
        with unheard():
            try:
                return self._pool.submit(function, *given, **named)
            except BrokenExecutor:
                self._pool = self._new()
                return self._pool.submit(function, *given, **named)

    def end(self) -> None:
        """Without waiting for what runs: a training goes on from its checkpoint the next time."""
        self._pool.shutdown(wait=False, cancel_futures=True)
        for process in multiprocessing.active_children():
            process.terminate()


def _begin() -> None:
    """In a new worker. Ctrl+C in a terminal reaches it, too; the parent decides."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    rest_while_waiting()
    end_with_parent()
