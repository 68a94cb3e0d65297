"""What background work has made, or in words that it could not."""

from __future__ import annotations

from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.work.background import Answer, Channel, Failure, Request


def answered(
    state: AppState, channel: Channel[Request, Answer], trouble: str
) -> tuple[Request, Answer] | None:
    """The next answer with its request; a failure is shown as `trouble` with its reason."""
    taken = channel.take()
    if taken is None:
        return None
    request, answer = taken
    if isinstance(answer, Failure):
        actions.fail(state, f"{trouble}: {answer.message}")
        return None
    return request, answer
