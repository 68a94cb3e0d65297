"""Background work done between frames, in the test's own thread."""

from __future__ import annotations

from typing import Any

from app.gui.actions import job_actions
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.gui.work.background import Channel
from renderer.gaussians import DynamicGaussians


def served(channels: Channels) -> list[Channel[Any, Any]]:
    """All but what the second worker does, and of that what is saved of a session."""
    return [*channels.of("first"), *channels.of("apart"), channels.sessions, channels.autosaves]


def keep_all(state: AppState) -> None:
    """What is to be on disk is there, or it has been told why not."""
    channels = Channels()
    channels.finish(state)
    _answer(state, channels)


def show_live(state: AppState, model: DynamicGaussians) -> None:
    """The model as it is now of the run that is made."""
    job_actions.show_live_model(state, model)
    follow_run(state)


def show_finished(state: AppState, model: DynamicGaussians) -> None:
    job_actions.show_finished_model(state, model)
    follow_run(state)


def follow_run(state: AppState) -> None:
    """What has been asked for of the run is there."""
    channels = Channels()
    channels.models.want(state.runs.model_wish)
    channels.left.want(state.runs.reconstruction.ended)
    for channel in (channels.models, channels.left):
        channel.run_waiting()
    _answer(state, channels)


def _answer(state: AppState, channels: Channels) -> None:
    for row in channels.rows:
        row.answer(state)


def settle(state: AppState, channels: Channels, now: float = 0.0) -> None:
    """Frames with all background work done in between, until nothing changes."""
    for _ in range(6):
        update(state, channels, now)
        for channel in served(channels):
            while channel.run_waiting():
                pass
