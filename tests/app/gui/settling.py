"""Background work done between frames, in the test's own thread."""

from __future__ import annotations

from app.gui.state.app_state import AppState
from app.gui.update.update import Channels, update


def settle(state: AppState, channels: Channels, now: float = 0.0) -> None:
    """Frames with all background work done in between, until nothing changes."""
    for _ in range(6):
        update(state, channels, now)
        for channel in channels.all:
            while channel.run_waiting():
                pass
