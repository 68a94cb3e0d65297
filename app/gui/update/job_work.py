"""Background work for the reconstruction that is made: its newest model, and what it leaves when it ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from app.gui.actions import job_actions, run_actions
from app.gui.state.app_state import AppState
from app.gui.update.answered import answered
from app.gui.work.background import Channel
from app.gui.work.run_models import Left, LeftRequest, ModelRequest, left_of, run_model
from app.scenes.scene import Scene


@dataclass
class JobWork:
    """Only the newest of each counts."""

    models: Channel[ModelRequest, Scene] = field(default_factory=lambda: Channel(run_model))
    left: Channel[LeftRequest, Left] = field(default_factory=lambda: Channel(left_of))

    @property
    def all(self) -> Sequence[Channel[Any, Any]]:
        return (self.models, self.left)

    def take(self, state: AppState) -> None:
        """Show what has been made since the last frame."""
        if (made := answered(state, self.models, "the reconstruction cannot be shown")) is not None:
            job_actions.take_model(state, *made)
        if (left := answered(state, self.left, "what the run has left cannot be told")) is not None:
            run_actions.take_left(state, *left)

    def ask(self, state: AppState) -> None:
        """Ask for what is not there."""
        self.models.want(state.runs.model_wish)
        self.left.want(state.runs.reconstruction.ended)
