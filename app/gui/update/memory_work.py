"""Memory that what was open before had needed, given back once something else is on screen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from app.gui.state.app_state import AppState
from app.gui.update.measure_work import at_rest
from app.gui.work.background import Channel
from app.gui.work.tidying import OnScreen, tidy


@dataclass
class MemoryWork:
    """Served last, when nothing else is wanted."""

    tidying: Channel[OnScreen, None] = field(default_factory=lambda: Channel(tidy))

    @property
    def all(self) -> Sequence[Channel[Any, Any]]:
        return (self.tidying,)

    def ask(self, state: AppState) -> None:
        """Once for everything that is opened, when it has come to rest."""
        if at_rest(state) and not state.pictures_wait and state.source.opening is None:
            self.tidying.want(OnScreen(state.source.path, state.source.clip))
