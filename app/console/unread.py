"""Work goes on where stderr can no longer be written: what is said there is no part of it."""

from __future__ import annotations

import io
import os
import sys


class Unread(io.TextIOWrapper):
    """As the stream whose buffer it takes, but silent from the first write that fails on: the reader of a
    pipe has left, or a disk is full."""

    def write(self, text: str) -> int:
        try:
            return super().write(text)
        except OSError:
            self._fall_silent()
            return len(text)

    def flush(self) -> None:
        try:
            super().flush()
        except OSError:
            self._fall_silent()

    def _fall_silent(self) -> None:
        """What the buffer still holds goes nowhere, too: it would be tried again at exit, and fail."""
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self.fileno())
        os.close(nowhere)
        super().flush()


def unread() -> None:
    """Let stderr be such a stream, unless somebody, such as a test, has put another in its place."""
    if isinstance(sys.stderr, io.TextIOWrapper) and sys.stderr is sys.__stderr__:
        told = sys.stderr
        sys.stderr = Unread(told.buffer, told.encoding, told.errors, line_buffering=True)
