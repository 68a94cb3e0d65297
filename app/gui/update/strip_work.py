"""Background work for the clip's row: its small images, and what of the present frame is left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.update.measure_work import at_rest
from app.gui.work.background import Channel, Failure
from app.gui.work.strip import LeftOut, LeftOutRequest, Strip, StripRequest, left_out, make_strip


@dataclass
class StripWork:
    """Served after measuring, when nothing else is wanted."""

    strip: Channel[StripRequest, Strip] = field(default_factory=lambda: Channel(make_strip))
    left_out: Channel[LeftOutRequest, LeftOut] = field(default_factory=lambda: Channel(left_out))

    @property
    def all(self) -> Sequence[Channel[Any, Any]]:
        return (self.left_out, self.strip)

    def take(self, state: AppState) -> None:
        """Show what has been made since the last frame."""
        for taken in (self.strip.take(), self.left_out.take()):
            if taken is None:
                continue
            match taken[1]:
                case Failure() as failure:
                    actions.say(state, f"the clip's thumbnails cannot be shown: {failure.message}")
                case Strip() as strip:
                    state.timeline.strip = strip
                case LeftOut() as masked:
                    state.picture.left_out = masked

    def ask(self, state: AppState) -> None:
        """Ask for what is not there, once the pictures are."""
        if state.source.clip is None or state.picture.pictures is None:
            return
        if at_rest(state) and state.timeline.strip_count > 0:
            self.strip.want(StripRequest(state.source.clip, state.timeline.strip_count))
        if state.picture.overlay:
            self.left_out.want(
                LeftOutRequest(state.source.clip, state.timeline.shown_index, state.source.part.mask)
            )
