"""What is written off the window's thread: small files that a person's clicks leave behind, in their order;
the queue; sessions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from app.files.atomic import write_bytes
from app.files.provenance import digest
from app.gui.session_file import Session, SessionSource, write_session
from app.runs.queue_file import keep_queue, queue_file
from app.runs.train_run import TrainRequest


@dataclass(frozen=True, eq=False)
class WriteRequest:
    """A file with its whole content."""

    path: Path
    content: bytes
    trouble: str
    """What it means that it cannot be written, as the beginning of a sentence."""
    announced: bool = False
    """A person has asked for the very file: what becomes of it is shown, else only trouble is noted."""


def write_file(request: WriteRequest) -> Iterator[Path]:
    """Answers a WriteRequest; folders above the file are made. Raises OSError or UserError."""
    write_bytes(request.path, request.content)
    yield request.path


@dataclass(frozen=True)
class QueueRequest:
    """The queue, for the file of this process in a folder."""

    folder: Path
    waiting: tuple[TrainRequest, ...]


def save_queue(request: QueueRequest) -> Iterator[Path]:
    """Answers a QueueRequest. Raises OSError or UserError."""
    path = queue_file(request.folder)
    keep_queue(path, request.waiting)
    yield path


@dataclass(frozen=True, eq=False)
class SessionRequest:
    """A session to be written."""

    path: Path
    session: Session
    in_passing: bool
    """Without the sources' digests, which take time, and without a word."""


def save_session(request: SessionRequest) -> Iterator[Path]:
    """Answers a SessionRequest. Raises OSError or UserError."""
    session, folder = request.session, request.path.parent
    if not request.in_passing:
        source, run = _hashed(session.source, folder), _hashed(session.run, folder)
        session = replace(session, source=source, run=run, second=_hashed(session.second, folder))
    write_session(request.path, session)
    yield request.path


def _hashed(source: SessionSource | None, folder: Path) -> SessionSource | None:
    path = source.found(folder / "session") if source is not None else None
    return replace(source, sha256=digest(path)) if source is not None and path is not None else source
