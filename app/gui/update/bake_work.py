"""Background work for a graphics card: keyframes of what the two 3D views show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.work.background import Channel, Failure
from app.gui.work.baking import Baked, BakeRequest, bake, can_bake
from app.scenes.scene import Scene

Bakes = Channel[BakeRequest, Baked]


@dataclass
class BakeWork:
    """A channel a view."""

    first: Bakes = field(default_factory=lambda: Channel(bake))
    second: Bakes = field(default_factory=lambda: Channel(bake))

    @property
    def all(self) -> Sequence[Channel[Any, Any]]:
        return (self.first, self.second)

    def take(self, state: AppState) -> None:
        """Keep what has been made since the last frame of what is still shown."""
        second = state.scene.second
        state.scene.baked = _taken(state, self.first, state.scene.model, "the 3D view") or state.scene.baked
        second.baked = _taken(state, self.second, second.shown, "the second 3D view") or second.baked

    def ask(self, state: AppState) -> None:
        """Ask for what is not there, where the card draws."""
        if not state.scene.processor_draws:
            _ask(self.first, state.scene.model, state.scene.baked)
            _ask(self.second, state.scene.second.shown, state.scene.second.baked)


def _taken(state: AppState, channel: Bakes, shown: Scene | None, view: str) -> Baked | None:
    """The next part of what `view` shows."""
    taken = channel.take()
    if taken is None or taken[0].shown is not shown:
        return None
    if isinstance(taken[1], Failure):
        actions.say(state, f"{view} has no keyframes: {taken[1].message}")
        return None
    if taken[1].said:
        actions.say(state, f"{view} {taken[1].said}")
    return taken[1]


def _ask(channel: Bakes, shown: Scene | None, baked: Baked | None) -> None:
    """Part by part, so that pictures are made between them."""
    asked = channel.asked
    if shown is None or not can_bake(shown):
        channel.want(None)
    elif asked is None or asked.shown is not shown:
        channel.ask(BakeRequest(shown))
    elif baked is not None and baked.request is asked and baked.keyframes is None:
        channel.ask(BakeRequest(shown, baked.baker))
