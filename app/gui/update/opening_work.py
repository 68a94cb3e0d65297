"""Background work that opens what a person points at; what takes long is said, and can be given up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final

from app.files.legible import legible
from app.gui.actions import actions, path_actions, second_actions, session_actions
from app.gui.state.app_state import AppState
from app.gui.state.window import Banner
from app.gui.work.background import Channel, Failure, NewestChannel
from app.gui.work.opening import Opened, OpenRequest, open_path

LONG: Final = 30.0
"""Seconds without an answer after which that is said: the file is large, or its drive does not answer."""


@dataclass
class Patience:
    """Since when an answer is waited for, and what has been said of it."""

    can_stop: bool
    """A person may give it up in the banner."""
    request: object = None
    since: float = 0.0
    said: Banner | None = None

    def follow(self, state: AppState, request: object, sentence: str) -> None:
        """Once a frame: say the sentence when the same request has had no answer for long; what was said goes
        when the answer has come."""
        if request != self.request:
            if self.said is not None and state.window.banner is self.said:
                state.window.banner = None
            self.request, self.since, self.said = request, state.window.now, None
        elif request is not None and self.said is None and state.window.now - self.since > LONG:
            why = "it is large, or its drive does not respond. You can open something else meanwhile"
            whole = f"{sentence} after {LONG:.0f} s: {why}"
            self.said = state.window.banner = Banner(legible(whole), self.can_stop)
            actions.say(state, whole)


@dataclass
class OpeningWork:
    """Each request has a thread of its own, see `Apart`."""

    first: Channel[OpenRequest, Opened] = field(default_factory=lambda: NewestChannel(open_path))
    second: Channel[OpenRequest, Opened] = field(default_factory=lambda: NewestChannel(open_path))
    """Of the second 3D view."""
    waits: tuple[Patience, Patience] = field(default_factory=lambda: (Patience(True), Patience(True)))

    @property
    def all(self) -> Sequence[Channel[Any, Any]]:
        return (self.first, self.second)

    def take(self, state: AppState) -> None:
        """Show what has been opened since the last frame."""
        if (taken := self.first.take()) is not None and taken[0] is state.source.opening:
            _show(state, *taken)
        if (second := self.second.take()) is not None:
            request, answer = second
            if isinstance(answer, Failure):
                second_actions.refuse_second(state, request, answer.message)
            else:
                second_actions.take_second(state, request, answer)

    def ask(self, state: AppState) -> None:
        """Ask for what is not there, and say what is long in coming."""
        wanted = (state.source.opening, state.scene.second.opening)
        for channel, request, wait in zip((self.first, self.second), wanted, self.waits, strict=True):
            channel.want(request)
            wait.follow(state, request, f"still waiting for {request.path}" if request else "")


def _show(state: AppState, request: OpenRequest, answer: Opened | Failure) -> None:
    if isinstance(answer, Failure):
        state.source.opening = None
        actions.fail(state, answer.message)
    elif answer.views is not None:
        state.source.opening = None
        path_actions.add_views(state, answer.views, request.path)
    else:
        actions.show_opened(state, request.path, answer)
        if answer.session is not None:
            session_actions.restore(state, answer.session)
            session_actions.taken_up(state, request.path)
