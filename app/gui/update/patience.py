"""Work that takes long is reported, and can be given up."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from app.files.legible import legible
from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.state.window import Banner

LONG: Final = 30.0
"""Seconds without an answer after which that is said: the file is large, or its drive does not answer."""


@dataclass
class Patience:
    """Since when an answer is waited for, and what has been said of it."""

    words: Callable[[Any], str]
    """Of a request, what waits for what."""
    can_stop: bool = True
    """A person may give it up in the banner."""
    request: object = None
    since: float = 0.0
    said: Banner | None = None

    def follow(self, state: AppState, request: object) -> None:
        """Once a frame: say so when the same request has had no answer for long; what was said goes when the
        answer has come."""
        if request != self.request:
            if self.said is not None and state.window.banner is self.said:
                state.window.banner = None
            self.request, self.since, self.said = request, state.window.now, None
        elif request is not None and self.said is None and state.window.now - self.since > LONG:
            why = "it is large, or its drive does not respond. You can open something else meanwhile"
            whole = f"{self.words(request)} after {LONG:.0f} s: {why}"
            self.said = state.window.banner = Banner(legible(whole), self.can_stop)
            actions.say(state, whole)
