"""What a user can do with the queue of reconstructions, as functions on the state. No ImGui."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

from app.errors import UserError
from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.state.reconstruction import Waiting
from app.gui.work.background import Failure
from app.gui.work.queued_clips import QueuedClip, QueuedClipRequest
from app.runs.queue_file import keep_queue, queue_file, take_over
from app.runs.train_run import TrainRequest


def why_held(state: AppState) -> str:
    """Why the next one does not start by itself, in a sentence; empty when it does."""
    if state.editing.is_under_way:
        return "The next one starts when you leave edit mode and the edits are saved or discarded."
    return ""


def withdraw(state: AppState, waiting: Waiting) -> None:
    """It is not made; nothing of it is on disk yet that was not there before."""
    state.runs.queue = tuple(each for each in state.runs.queue if each is not waiting)


def empty(state: AppState) -> None:
    """None of those that wait is made."""
    state.runs.queue = ()


def to_front(state: AppState, waiting: Waiting) -> None:
    """It is the next one, also if it is of an earlier session."""
    if any(each is waiting for each in state.runs.queue):
        others = tuple(each for each in state.runs.queue if each is not waiting)
        state.runs.wakings += waiting.asleep
        state.runs.queue = (replace(waiting, asleep=False) if waiting.asleep else waiting, *others)


def last_to_front(state: AppState) -> None:
    if state.runs.queue:
        to_front(state, state.runs.queue[-1])


# ---- from one session to the next


def take_up(state: AppState) -> None:
    """At the start: what waited when an earlier window was closed, or died, waits again, asleep."""
    try:
        requests, damage = take_over(state.places.config)
    except (OSError, UserError) as error:
        actions.say(state, f"the queue of the earlier session cannot be restored: {error}")
        return
    state.runs.queue = tuple(Waiting(None, request, asleep=True) for request in requests)
    if requests:
        count = len(requests)
        waiting = "1 reconstruction is" if count == 1 else f"{count} reconstructions are"
        actions.announce(state, f"{waiting} queued since an earlier session: see Runs")
    if damage:
        actions.fail(state, damage)


def to_keep(state: AppState) -> tuple[TrainRequest, ...]:
    """What the next session is to find; nothing where paths are not remembered."""
    return tuple(waiting.request for waiting in state.runs.queue) if state.settings.remember_recent else ()


def keep_now(state: AppState) -> None:
    """The window closes."""
    with suppress(OSError, UserError):
        keep_queue(queue_file(state.places.config), to_keep(state))


def sleeps(state: AppState) -> bool:
    """Some of those that wait are of an earlier session, and nobody has said that they are to be made."""
    return any(waiting.asleep for waiting in state.runs.queue)


def wake(state: AppState) -> None:
    """Those of an earlier session are to be made, each in its turn."""
    state.runs.wakings += 1
    state.runs.queue = tuple(
        replace(each, asleep=False) if each.asleep else each for each in state.runs.queue
    )


def take_clip(state: AppState, request: QueuedClipRequest, answer: QueuedClip | Failure) -> None:
    """Its clip is open: where it is the one that is shown, that very one. Else it waits until it is asked for
    again, or taken out."""
    wanted, shown = request.request, state.source.clip

    def renewed(waiting: Waiting) -> Waiting:
        if waiting.request != wanted:
            return waiting
        if isinstance(answer, Failure):
            return replace(waiting, asleep=True)
        now = (answer.clip.path, wanted.clip_options)
        same = shown is not None and (shown.path, state.source.options) == now
        return replace(waiting, clip=shown if same else answer.clip, told=answer.told)

    state.runs.queue = tuple(map(renewed, state.runs.queue))
    if isinstance(answer, Failure):
        said = f"{wanted.run_path.name} was not started; it stays in the queue: {answer.message}"
        actions.fail(state, said)
