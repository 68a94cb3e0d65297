"""Background work for the reconstructions that wait: keeping them on disk, opening clips of kept ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from app.gui.actions import actions, queue_actions
from app.gui.state.app_state import AppState
from app.gui.update.opening_work import Patience
from app.gui.work.background import Channel, Failure, NewestChannel
from app.gui.work.queue_keeping import KeepRequest, TakenUp, TakeUpRequest, keep, take_up
from app.runs.queue_file import queue_file


@dataclass
class QueueWork:
    """Served after all that a picture waits for."""

    kept: Channel[KeepRequest, Path] = field(default_factory=lambda: Channel(keep))
    clips: Channel[TakeUpRequest, TakenUp] = field(default_factory=lambda: NewestChannel(take_up))
    patience: Patience = field(default_factory=lambda: Patience(False))

    @property
    def all(self) -> Sequence[Channel[Any, Any]]:
        return (self.kept, self.clips)

    def take(self, state: AppState) -> None:
        """Note what has been done since the last frame."""
        if (opened := self.clips.take()) is not None:
            request, answer = opened
            if isinstance(answer, Failure):
                queue_actions.put_back(state, request.request, answer.message)
            else:
                queue_actions.give_clip(state, request.request, answer.clip, answer.told)
        written = self.kept.take()
        if written is not None and isinstance(written[1], Failure):
            actions.say(state, f"the queue cannot be saved: {written[1].message}")

    def ask(self, state: AppState) -> None:
        """Ask for what is not there."""
        self.kept.want(KeepRequest(queue_file(state.places.config), queue_actions.to_keep(state)))
        wanted = queue_actions.without_clip(state)
        request = TakeUpRequest(wanted, state.runs.wakings) if wanted is not None else None
        if request is not None:
            self.clips.want(request)
        clip = f"{wanted.run_path.name} waits for its clip {wanted.clip_path}" if wanted is not None else ""
        self.patience.follow(state, request, clip)
