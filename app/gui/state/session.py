"""The session's notes, and where it is kept. A part of the state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from app.gui.session_file import Case, Session


@dataclass
class KeptSession:
    """Session actions change it; drawing reads it."""

    notes: str = ""
    notes_asked: bool = False
    """Whether their panel is to be shown."""
    begins_writing: bool = False
    """Whether the field for them takes the keyboard when it is next drawn."""
    path: Path | None = None
    """Where the session was opened from or saved to."""
    saved: Session | None = None
    """The substance of it, as it is in that file."""
    saved_case: Case | None = None
    """Notes and case summary, as they are in the newest file."""
    discarded: Case | None = None
    """The same, as a person has agreed to lose them."""
    is_unsaved: bool = False
    """Something has changed since, in a session that has a file."""
    leaving: Callable[[], None] | None = None
    """What waits for an answer to "save the changes?"."""
    asks_new_case: bool = False
    """Whether a question stands: notes and case summary are to begin anew."""
    after_saving: Callable[[], None] | None = None
    """What goes on once they are saved."""
    recoverable: Path | None = None
    """A session that ended unexpectedly, until it is restored or declined."""
    recoverable_since: str = ""
    """When it was last saved."""
    autosaved: Session | None = None
    """The newest that was saved in passing, or is about to be."""
    autosaved_at: float = 0.0
    autosave_trouble: str = ""
