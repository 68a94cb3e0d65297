"""The record beside a recording, written in a thread of its own: the encoder does not wait for the disk."""

from __future__ import annotations

import time
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, Final

from app.files.provenance import write_sidecar

APART: Final = 1.0
"""Seconds from one writing to the next, and so what a kill may cost of the record."""


class Sidecar:
    """Of one recording; to be called from one thread, and closed in the end."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._writer = ThreadPoolExecutor(1, "vesselsplat-sidecar")
        self._writing: Future[None] | None = None
        self._due = 0.0

    def has_time(self) -> bool:
        """Whether the next writing may begin. Raises UserError, OSError: the one before has failed."""
        if self._writing is not None and self._writing.done():
            done, self._writing = self._writing, None
            done.result()
        return self._writing is None and time.perf_counter() >= self._due

    def begin(self, facts: dict[str, Any]) -> None:
        """Write these, which nobody changes from here on; where it `has_time`."""
        self._due = time.perf_counter() + APART
        self._writing = self._writer.submit(write_sidecar, self._path, facts)

    def close(self) -> None:
        """Wait for what is under way. Raises UserError, OSError: it has failed."""
        self._writer.shutdown()
        if self._writing is not None:
            self._writing.result()
