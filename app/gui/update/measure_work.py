"""Measuring in a thread of its own, once the hand rests: it never makes a slider wait."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from app.enhancement.frame_enhancer import Pictures
from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.work.background import Channel, Failure
from app.gui.work.measuring import Measured, Measurer

REST = 0.25
"""Seconds without a new picture before what can wait is done: measuring, small pictures, tidying."""


def at_rest(state: AppState) -> bool:
    """Whether no new picture has been asked for lately."""
    return not state.timeline.playing and state.window.now - state.picture.asked_at >= REST


@dataclass
class MeasureWork:
    """What needs neither numba nor OpenGL."""

    measures: Channel[Pictures, Measured] = field(default_factory=lambda: Channel(Measurer().measure))

    @property
    def all(self) -> Sequence[Channel[Any, Any]]:
        return (self.measures,)

    def take(self, state: AppState) -> None:
        """Show what has been measured since the last frame."""
        taken = self.measures.take()
        if taken is None:
            return
        if isinstance(taken[1], Failure):
            actions.say(state, f"the frame cannot be measured: {taken[1].message}")
        else:
            state.picture.measured = taken[1]

    def ask(self, state: AppState) -> None:
        """Ask for what is not there."""
        pictures = state.picture.pictures
        if pictures is None or pictures.enhanced is None or self.measures.asked is pictures:
            return
        if at_rest(state) and not state.pictures_are_stale:
            self.measures.ask(pictures)
