"""Ctrl+C, and SIGTERM and SIGHUP of batch systems and lost terminals, end a command in one way."""

from __future__ import annotations

import _thread
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

SOON = 0.05  # s
INTERRUPTED = 128
"""Added to a signal's number, it is the exit code."""
ENDING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
UNTOUCHED = (signal.SIG_DFL, signal.default_int_handler)


@contextmanager
def noted(most: int | None = None) -> Iterator[Callable[[], bool]]:
    """Whether a signal has come: within it none interrupts, where something would be left half-way.

    What the signal would have done is done at the end; at once after `most` of them, where that is given.
    """
    came: list[int] = []
    before: dict[int, Any] = {}

    def note(number: int, frame: FrameType | None) -> None:
        if most is not None and len(came) >= most:
            before[number](number, frame)
        came.append(number)

    if threading.current_thread() is threading.main_thread():
        for number in ENDING:
            if callable(signal.getsignal(number)):
                before[number] = signal.signal(number, note)
    try:
        yield lambda: bool(came)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if came:
            before[came[0]](came[0], None)


@contextmanager
def ended_by_ctrl_c() -> Iterator[Callable[[], bool]]:
    """Whether Ctrl+C has come, for what is ended so in good order: it interrupts from the second time on."""
    has_come, before = False, signal.getsignal(signal.SIGINT)

    def note(number: int, frame: FrameType | None) -> None:
        nonlocal has_come
        if has_come and callable(before):
            before(number, frame)
        has_come = True

    is_heard = threading.current_thread() is threading.main_thread() and callable(before)
    if is_heard:
        signal.signal(signal.SIGINT, note)
    try:
        yield lambda: has_come
    finally:
        if is_heard:
            signal.signal(signal.SIGINT, before)


@contextmanager
def unheard() -> Iterator[None]:
    """Processes that begin meanwhile are not ended by Ctrl+C or a lost terminal, not even while Python starts
    in them; here these come at the end. Not on Windows, where processes inherit nothing of it."""
    if sys.platform == "win32":
        yield
        return
    from multiprocessing import resource_tracker  # Commands that start no process do without.

    resource_tracker.ensure_running()  # As it starts, it lets both through again.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT, signal.SIGHUP))
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class Interrupted(KeyboardInterrupt):
    """Where a plain KeyboardInterrupt has passed a library in C, Python ends by SIGINT whatever its code."""


class EndingSignals:
    """While it is entered, these signals raise KeyboardInterrupt in the main thread, and none is lost.

    Where Python cannot raise it, as in what a library in C calls back, it is raised again a moment later;
    where such a library makes an error of its own of it, it leaves in place of that error.
    """

    def __init__(self) -> None:
        self.code = INTERRUPTED + signal.SIGINT
        """Exit code of a command that was interrupted."""
        self._before: dict[int, Any] = {}
        self._unraisable_before = sys.unraisablehook
        self._entered, self._number, self._came = False, signal.SIGINT, False

    def __enter__(self) -> EndingSignals:
        self._entered, self._unraisable_before = True, sys.unraisablehook
        sys.unraisablehook = self._unraisable
        if threading.current_thread() is threading.main_thread():
            for number in ENDING:
                # What was ignored stays so, as under nohup.
                if signal.getsignal(number) in UNTOUCHED:
                    self._before[number] = signal.signal(number, self._interrupt)
        return self

    def __exit__(self, _kind: object, error: BaseException | None, _traceback: object) -> None:
        self._entered, sys.unraisablehook = False, self._unraisable_before
        for number, before in self._before.items():
            signal.signal(number, before)
        if self._came and isinstance(error, Exception):
            raise Interrupted from error

    def _unraisable(self, told: sys.UnraisableHookArgs) -> None:
        if not issubclass(told.exc_type, KeyboardInterrupt):
            self._unraisable_before(told)
            return
        timer = threading.Timer(SOON, self._raise_again)
        timer.daemon = True
        timer.start()

    def _raise_again(self) -> None:
        if self._entered:
            _thread.interrupt_main(self._number)

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        self.code, self._number, self._came = INTERRUPTED + number, signal.Signals(number), True
        raise Interrupted
