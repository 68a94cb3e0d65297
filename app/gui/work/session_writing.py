"""Writes a session, with the digests of its sources where there is time for them: off the window's thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from app.files.provenance import digest
from app.gui.session_file import Session, SessionSource, write_session


@dataclass(frozen=True, eq=False)
class SessionRequest:
    """A session to be written."""

    path: Path
    session: Session
    in_passing: bool
    """Without the sources' digests, which take time, and without a word."""


def write(request: SessionRequest) -> Iterator[Path]:
    """Answers a SessionRequest. Raises OSError or UserError."""
    session, folder = request.session, request.path.parent
    if not request.in_passing:
        source, run = _hashed(session.source, folder), _hashed(session.run, folder)
        session = replace(session, source=source, run=run)
    write_session(request.path, session)
    yield request.path


def _hashed(source: SessionSource | None, folder: Path) -> SessionSource | None:
    path = source.found(folder / "session") if source is not None else None
    return replace(source, sha256=digest(path)) if source is not None and path is not None else source
