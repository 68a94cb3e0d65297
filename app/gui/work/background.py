"""Work off the window's thread. What piles up is dropped, oldest first: only the newest request matters."""

from __future__ import annotations

import logging
import os
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, Generic, TypeVar

from app.errors import sentence
from app.files.legible import located

Request = TypeVar("Request")
Answer = TypeVar("Answer")

log = logging.getLogger(__name__)

REST = 1.0
"""Seconds without work after which a worker rests."""


class Failure:
    """An exception as an answer: the one line a person reads."""

    def __init__(self, error: Exception) -> None:
        self.message = sentence(error)
        self.error = error.with_traceback(None)
        """Without the frames that it and what led to it came through, whose arrays would stay in memory."""
        error.__cause__ = error.__context__ = None

    @property
    def placed(self) -> str:
        """The same, with the folder of the file that the system refused: where the program chose it."""
        file = self.error.filename if isinstance(self.error, OSError) else None
        return f"{self.message} in {located(Path(str(file)).parent)}" if file else self.message


class Channel(Generic[Request, Answer]):
    """One kind of work: ask with a request, take its answer.

    `work` yields one or more answers to a request, each better than the last. At most `depth` requests and
    answers are kept, the newest; a request with better answers still to come gives way to a newer one.
    """

    def __init__(self, work: Callable[[Request], Iterator[Answer]], depth: int = 1) -> None:
        self._work = work
        self._lock = threading.Lock()
        self._waiting: deque[Request] = deque(maxlen=depth)
        self._answers: deque[tuple[Request, Answer | Failure]] = deque(maxlen=depth)
        self._wake: Callable[[], None] = lambda: None
        self._done = threading.Event()
        self.asked: Request | None = None
        """The newest request, answered or not."""

    def ask(self, request: Request) -> None:
        with self._lock:
            self.asked = request
            self._waiting.append(request)
            self._done.clear()
        self._wake()

    def wait(self, seconds: float) -> None:
        """Return as soon as the newest request has its last answer, or after that many seconds."""
        self._done.wait(seconds)

    def want(self, request: Request | None) -> None:
        """Ask, unless it is what was asked last. That is forgotten, with the clips and models in it, where
        there is nothing to ask for."""
        if request is None:
            self.asked = None
        elif self.asked != request:
            self.ask(request)

    def take(self) -> tuple[Request, Answer | Failure] | None:
        """The next answer with its request, once each; None when there is none."""
        with self._lock:
            return self._answers.popleft() if self._answers else None

    def attach(self, wake: Callable[[], None]) -> None:
        """Call `wake` whenever there is something to do."""
        self._wake = wake

    def close(self) -> None:
        """Called by the thread that has done the work, when no more will be done."""

    def run_waiting(self, on_answer: Callable[[], None] = lambda: None) -> bool:
        """Do what waits, in the calling thread. False when nothing waited."""
        with self._lock:
            if not self._waiting:
                return False
            request = self._waiting.popleft()
        try:
            for answer in self._work(request):
                self._put(request, answer)
                on_answer()
                if self._waiting:
                    break
        except Exception as error:
            log.info("request failed", exc_info=True)
            self._put(request, Failure(error))
            on_answer()
        with self._lock:
            if not self._waiting:
                self._done.set()
        return True

    def _put(self, request: Request, answer: Answer | Failure) -> None:
        with self._lock:
            self._answers.append((request, answer))


class NewestChannel(Channel[Request, Answer]):
    """Only answers to what was asked last count: a late one never takes the place of one that is awaited."""

    def _put(self, request: Request, answer: Answer | Failure) -> None:
        with self._lock:
            if request is self.asked:
                self._answers.append((request, answer))


class SteppedChannel(Channel[Request, Answer]):
    """Long work, a step at a time, so that other channels are served between two answers."""

    def __init__(self, work: Callable[[Request], Iterator[Answer]], depth: int = 1) -> None:
        super().__init__(work, depth)
        self._under_way: tuple[Request, Iterator[Answer]] | None = None
        self._cancelled = threading.Event()

    def want(self, request: Request | None) -> None:
        """Ask, unless it is what was asked last; where there is nothing to ask for, that is given up."""
        if request is None and self.asked is not None:
            self.cancel()
        super().want(request)

    def cancel(self) -> None:
        """Give up what is under way or waits; it is cleared away with the next step."""
        with self._lock:
            self._waiting.clear()
            self._cancelled.set()
        self._wake()

    def run_waiting(self, on_answer: Callable[[], None] = lambda: None) -> bool:
        """Do one step of what is under way or waits. False when there is nothing."""
        given_up = None
        with self._lock:
            if self._cancelled.is_set():
                self._cancelled.clear()
                given_up, self._under_way = self._under_way, None
            if self._under_way is None and self._waiting:
                request = self._waiting.popleft()
                self._under_way = request, iter(self._work(request))
        # Without the lock, for which the window's thread would wait.
        _end(given_up)
        if self._under_way is None:
            return False
        request, steps = self._under_way
        try:
            self._put(request, next(steps))
        except StopIteration:
            self._under_way = None
        except Exception as error:
            log.info("request failed", exc_info=True)
            self._under_way = None
            self._put(request, Failure(error))
        on_answer()
        return True

    def close(self) -> None:
        """What is under way leaves nothing half-written."""
        _end(self._under_way)
        self._under_way = None


def _end(work: tuple[Any, Iterator[Any]] | None) -> None:
    """Close its steps, which removes what they had begun to write. A drive that is gone by now, where they
    cannot, is no trouble of other work."""
    if work is not None and isinstance(work[1], Generator):
        try:
            work[1].close()
        except Exception:
            log.info("what was given up is not cleared away", exc_info=True)


class Worker:
    """One thread that serves several channels in turn: numba has a pool of threads for each that computes.

    `at_rest` is called there once after all work, when no more has come for a while.
    """

    def __init__(
        self,
        channels: Sequence[Channel[Any, Any]],
        on_answer: Callable[[], None],
        at_rest: Callable[[], None] = lambda: None,
    ) -> None:
        self._channels = tuple(channels)
        self._on_answer, self._at_rest = on_answer, at_rest
        self._wake, self._closing = threading.Event(), threading.Event()
        for channel in self._channels:
            channel.attach(self._wake.set)
        self._thread = threading.Thread(target=self._run, name="vesselsplat-worker", daemon=True)
        self._thread.start()

    def close(self, timeout: float = 2.0) -> None:
        """Stops after the work in hand, which the process does not wait for longer than `timeout` seconds."""
        self._closing.set()
        self._wake.set()
        self._thread.join(timeout)

    @property
    def is_alive(self) -> bool:
        return self._thread.is_alive()

    def _run(self) -> None:
        self._wake.wait()
        while not self._closing.is_set():
            self._wake.clear()
            while self._serve():
                pass
            # A call to close may have come just before the wake-up was cleared.
            if not self._closing.is_set() and not self._wake.wait(REST):
                self._at_rest()
                self._wake.wait()
        for channel in self._channels:
            channel.close()

    def _serve(self) -> bool:
        """Each channel once, none once it is to close: whether any had something to do."""
        served = False
        for channel in self._channels:
            if self._closing.is_set():
                return False
            served = channel.run_waiting(self._on_answer) or served
        return served


class Apart:
    """Serves a channel whose work may never end, as on a drive that does not answer: each request has a
    thread of its own, so that one that hangs stops neither the next nor any other work.

    Such work does without numba, which has a pool of threads for each that computes.
    """

    def __init__(self, channel: Channel[Any, Any], on_answer: Callable[[], None]) -> None:
        self._channel, self._on_answer = channel, on_answer
        self._threads: tuple[threading.Thread, ...] = ()
        channel.attach(self._begin)

    def close(self, timeout: float = 2.0) -> None:
        """The process does not wait longer for what is under way."""
        end = time.monotonic() + timeout
        for thread in self._threads:
            thread.join(max(end - time.monotonic(), 0.0))

    @property
    def is_alive(self) -> bool:
        return any(thread.is_alive() for thread in self._threads)

    def _begin(self) -> None:
        thread = threading.Thread(
            target=self._channel.run_waiting, args=(self._on_answer,), name="vesselsplat-opening", daemon=True
        )
        self._threads = (*(each for each in self._threads if each.is_alive()), thread)
        thread.start()


def leave(workers: Iterable[Worker | Apart]) -> None:
    """End the process at once where a closed worker is still at work, which nothing waits for: when Python
    ends, a thread in a library of C++ would abort it. All that is to be kept is on disk by now."""
    if any(worker.is_alive for worker in workers):
        for stream in filter(None, (sys.stdout, sys.stderr)):
            stream.flush()
        os._exit(0)
