"""After a crash: the session that an earlier window left is offered, and restored or declined."""

from __future__ import annotations

import os
from contextlib import suppress
from datetime import datetime

from app.files.legible import to_minute
from app.gui.actions import actions
from app.gui.session_file import SUFFIX, autosave_path, recoverable
from app.gui.state.app_state import AppState


def offer_recovery(state: AppState) -> None:
    """At the start: whether an earlier session ended without an end."""
    try:
        state.session.recoverable = found = recoverable(state.places.config)
        if found is not None:
            saved = datetime.fromtimestamp(found.stat().st_mtime)
            state.session.recoverable_since = to_minute(saved)
    except OSError as error:
        actions.say(state, f"earlier sessions cannot be listed: {error}")


def recover(state: AppState) -> None:
    """Open what a crash left; its file goes only when all of it is open."""
    found, state.session.recoverable = state.session.recoverable, None
    if found is None:
        return
    if found.exists():
        actions.open_path(state, found)
    else:
        actions.fail(state, "the earlier session has been restored, or declined, in another window")


def decline(state: AppState) -> None:
    """Start afresh; the file is kept under another name, for a second thought."""
    if state.session.recoverable is not None:
        kept = state.session.recoverable.with_name(f"declined{SUFFIX}")
        with suppress(OSError):
            os.replace(state.session.recoverable, kept)
            actions.say(state, f"the earlier session was saved as {kept}")
    state.session.recoverable = None


def end(state: AppState) -> None:
    """The window closes as it should: nothing needs to be recovered."""
    with suppress(OSError):
        autosave_path(state.places.config).unlink()
