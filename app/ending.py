"""SIGTERM and SIGHUP, as batch systems and lost terminals send them, end a command as Ctrl+C does."""

from __future__ import annotations

import signal
import threading
from types import FrameType
from typing import Any

INTERRUPTED = 128
"""Added to a signal's number, it is the exit code."""
ENDING = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))


class EndingSignals:
    """While it is entered, these signals raise KeyboardInterrupt in the main thread."""

    def __init__(self) -> None:
        self.code = INTERRUPTED + signal.SIGINT
        """Exit code of a command that was interrupted."""
        self._before: dict[int, Any] = {}

    def __enter__(self) -> EndingSignals:
        if threading.current_thread() is threading.main_thread():
            for number in ENDING:
                # What was ignored stays so, as under nohup.
                if signal.getsignal(number) is signal.SIG_DFL:
                    self._before[number] = signal.signal(number, self._interrupt)
        return self

    def __exit__(self, *_: object) -> None:
        for number, before in self._before.items():
            signal.signal(number, before)

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        self.code = INTERRUPTED + number
        raise KeyboardInterrupt
