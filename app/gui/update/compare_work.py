"""Background work for the two panes: other images of the same frame, and the difference of both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from app.exports.comparison_images import (
    Difference,
    DifferenceRequest,
    Other,
    OtherMaker,
    OtherRequest,
    heat_map,
)
from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.state.comparison import SIDES, Side
from app.gui.state.panes import other_request
from app.gui.work.background import Channel, Failure


def _channels() -> dict[Side, Channel[OtherRequest, Other]]:
    maker = OtherMaker()
    return {side: Channel(maker.make) for side in SIDES}


@dataclass
class CompareWork:
    """One channel a side, which share what they remember; the difference is asked for like any other work."""

    sides: dict[Side, Channel[OtherRequest, Other]] = field(default_factory=_channels)
    difference: Channel[DifferenceRequest, Difference] = field(default_factory=lambda: Channel(heat_map))

    @property
    def all(self) -> Sequence[Channel[Any, Any]]:
        return (*self.sides.values(), self.difference)

    def take(self, state: AppState) -> None:
        """Show what has been made since the last frame."""
        for side, channel in self.sides.items():
            if (taken := channel.take()) is None:
                continue
            request, answer = taken
            if not isinstance(answer, Failure):
                state.comparing.others[side] = answer
            elif request == other_request(state, side):
                state.timeline.playing = False
                actions.fail(state, f"the {side} pane cannot be shown: {answer.message}")

    def ask(self, state: AppState) -> None:
        """Ask for what is not there; say whether the panes wait for it."""
        wanted = {side: other_request(state, side) for side in SIDES}
        have = {other.request for other in state.comparing.others.values()}
        state.comparing.waits = any(one is not None and one not in have for one in wanted.values())
        for side, one in wanted.items():
            # A failed request is not asked for again until something has changed.
            if one is not None and one not in have and self.sides[side].asked != one:
                self.sides[side].ask(one)
