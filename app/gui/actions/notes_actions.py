"""What a user can do with the notes of a session, as functions on the state. No ImGui."""

from __future__ import annotations

from app.enhancement.settable import LONGEST_NOTES
from app.gui.state.app_state import AppState


def begin_writing(state: AppState, begins: bool) -> None:
    """What is typed next is a note, not keys of commands."""
    state.session.begins_writing = begins


def notes_came(state: AppState) -> None:
    """Their panel is shown."""
    state.session.notes_asked = False


def write_notes(state: AppState, text: str) -> None:
    """What a person writes down; as much of it as a session keeps."""
    state.session.notes = text[:LONGEST_NOTES]
