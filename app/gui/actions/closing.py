"""What closing the window would end, and what of that is kept, as functions on the state. No ImGui."""

from __future__ import annotations

from app.gui.actions import queue_actions
from app.gui.state.app_state import AppState
from app.gui.state.run_words import KEEPS


def at_stake(state: AppState) -> str:
    """What closing the window would end, in sentences; empty when it ends nothing."""
    return " ".join(what for what, _ in _stakes(state))


def what_is_kept(state: AppState) -> str:
    """What is kept of what closing the window would end, in sentences."""
    return " ".join(kept for _, kept in _stakes(state) if kept)


def _stakes(state: AppState) -> tuple[tuple[str, str], ...]:
    """What would end, each with what is kept of it."""
    masks = "Tools are still being masked." if state.masking.making is not None else ""
    batch = "Files and folders are still being enhanced." if state.batches.under_way is not None else ""
    export = "An export is still being written." if state.exports.under_way is not None else ""
    stakes = (
        (_run(state), _kept_of_run(state)),
        (_queue(state), _kept_of_queue(state)),
        (batch, "Finished files are kept; the rest are not written."),
        (export, "What the export has written so far is discarded."),
        (_images(state), "Images not saved yet are lost."),
        (masks, "Masks made so far stay."),
    )
    return tuple(stake for stake in stakes if stake[0])


def _images(state: AppState) -> str:
    count = len(state.exports.saving)
    still = "1 image is" if count == 1 else f"{count} images are"
    return f"{still} still being saved." if count else ""


def _run(state: AppState) -> str:
    run, count = state.runs.reconstruction, len(state.runs.queue)
    if not run.is_alive:
        return ""
    name = run.run_path.name if run.run_path else "A reconstruction"
    stands = "paused" if run.status == "paused" else "still running"
    waits = "1 more is queued" if count == 1 else f"{count} more are queued"
    return f"{name} is {stands}{f', and {waits}' if count else ''}."


def _kept_of_run(state: AppState) -> str:
    begun = KEEPS if state.runs.reconstruction.iteration else "It has not done an iteration yet."
    return f"{begun} {_kept_of_queue(state)}" if state.runs.queue else begun


def _queue(state: AppState) -> str:
    """Where none is under way: what waits is told with that one."""
    count = len(state.runs.queue)
    if not count or state.runs.reconstruction.is_alive or queue_actions.to_keep(state):
        return ""
    return "1 reconstruction is queued." if count == 1 else f"{count} reconstructions are queued."


def _kept_of_queue(state: AppState) -> str:
    return f"The queue is {'kept for the next start' if queue_actions.to_keep(state) else 'discarded'}."


def may_close(state: AppState) -> bool:
    """Whether the window can close without a question; else the question is asked."""
    if state.window.closing == "agreed" or not at_stake(state):
        return True
    state.window.closing = "asked"
    return False


def answer_closing(state: AppState, *, close: bool) -> None:
    state.window.closing = "agreed" if close else "no"
