"""Keeps the reconstructions that wait for the next session, off the window's thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from app.runs.queue_file import keep_queue
from app.runs.train_run import TrainRequest


@dataclass(frozen=True)
class KeepRequest:
    """What the file is to hold."""

    path: Path
    waiting: tuple[TrainRequest, ...]


def keep(request: KeepRequest) -> Iterator[Path]:
    """Answers a KeepRequest. Raises OSError or UserError."""
    keep_queue(request.path, request.waiting)
    yield request.path
