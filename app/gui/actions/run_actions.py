"""What a user can do with the runs of the open clip, as functions on the state. No ImGui."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from app.gui.actions import actions, job_actions, second_actions
from app.gui.state.app_state import AppState
from app.gui.state.reconstruction import Waiting
from app.gui.state.scene import Second
from app.gui.work.background import Failure
from app.gui.work.runs import FoundRuns, Left, LeftRequest, ListedRun, RunsRequest
from app.runs.structuring import NO_DEPTH


def take_found(state: AppState, request: RunsRequest, answer: FoundRuns | Failure) -> None:
    """Show what was found for the clip that is open."""
    if isinstance(answer, FoundRuns):
        state.runs.found = answer
    elif state.runs.trouble != answer.message:
        state.runs.trouble = answer.message
        actions.fail(state, f"earlier reconstructions cannot be listed: {answer.message}")


def is_present(state: AppState, run: ListedRun) -> bool:
    """It is the very one that this window makes now."""
    return state.runs.reconstruction.is_alive and state.runs.reconstruction.run_path == run.path


def is_in_training(state: AppState, run: ListedRun) -> bool:
    """In this window or by another process."""
    return is_present(state, run) or run.made == "training"


def shown_from_elsewhere(state: AppState) -> Path | None:
    """The run that is shown, where it lies in another folder than the clip's listed ones."""
    model = state.editing.base or state.scene.model
    if model is None or not model.is_of_run or model.path is None or model.path.parent == state.places.runs:
        return None
    return model.path


def open_run(state: AppState, run: ListedRun) -> None:
    """In place of what is shown; while another one is made, beside it. An unfinished one as last kept."""
    if why_not_open(state, run):
        return
    if state.runs.reconstruction.is_alive:
        second_actions.open_second(state, run.path)
    else:
        actions.open_run(state, run.path)


def open_again(state: AppState) -> None:
    """The run that is shown, as far as another process has trained it by now."""
    if (path := state.runs.reconstruction.run_path) is not None:
        actions.open_run(state, path)


def is_as_it_is(state: AppState, run: ListedRun) -> bool:
    """Of the run that is shown: there is no more of it to show, neither of its model nor, as where its
    training has found the cameras or the lens, of its frames."""
    return run.made == state.runs.reconstruction.status == "finished" and state.has_frames


def why_not_open(state: AppState, run: ListedRun) -> str:
    """In a sentence; empty when it can be opened."""
    if is_present(state, run):
        return "This one is in training: see Reconstruction."
    if not state.runs.reconstruction.is_alive:
        return ""
    if not run.has_model:
        return "It has no model to show beside the one in training."
    return "" if state.scene.model is not None else "Wait for the first preview of the one in training."


def is_beside(state: AppState, run: ListedRun) -> bool:
    """It is what the second view shows."""
    shown = state.scene.second.model
    return shown is not None and shown.path == run.path


def toggle_beside(state: AppState, run: ListedRun) -> None:
    """In the second view, with the first one's camera and time; or no longer."""
    if is_beside(state, run):
        second_actions.close_second(state)
    elif not why_not_beside(state, run):
        second_actions.open_second(state, run.path)


def why_not_beside(state: AppState, run: ListedRun) -> str:
    """In a sentence; empty when it can be shown beside the first."""
    model = state.scene.model
    if model is None:
        return "Open another reconstruction first."
    if model.path == run.path or is_present(state, run):
        return "It is the one that is shown: open another one beside it."
    return "" if run.has_model else "It has no model to show."


def continue_run(state: AppState, run: ListedRun) -> None:
    """Go on with it as it was begun: at once, or when its turn comes."""
    if state.source.clip is not None and not why_not_continue(state, run):
        waiting = Waiting(state.source.clip, replace(run.request, resume=True), run.told)
        job_actions.enqueue(state, (waiting,))


def why_not_continue(state: AppState, run: ListedRun) -> str:
    """In a sentence; empty when it can go on."""
    if run.made == "finished":
        return "It is finished."
    if is_in_training(state, run):
        return "It is in training."
    if state.runs.is_queued(run.path):
        return "It is queued."
    if not run.request.clip_options.reads_as(state.source.options):
        return "It was started with other options for reading the clip: open it first."
    return ""


def take_left(state: AppState, request: LeftRequest, left: Left) -> None:
    """What the run has left that ended last."""
    run = state.runs.reconstruction
    if request is run.ended and run.request is not None:
        run.has_checkpoint = left.has_checkpoint
        run.saved_nothing = run.status == "failed" and not left.is_run
        run.way_out = way_out(left, run.failure) if run.status == "failed" else ""


def way_out(left: Left, failure: str) -> str:
    """What can be done with a run that failed, in a sentence or two."""
    if not left.is_run and failure.startswith(NO_DEPTH):
        return "Nothing was saved: choose Guessed (no scale) for Depth, and start again."
    if not left.is_run:
        return "Nothing was saved: correct the problem named above and start again."
    if left.has_checkpoint:
        return "Continue resumes from the last checkpoint; View model shows the model as last seen."
    return "There is no checkpoint: Continue starts over."


def has_preview(state: AppState, path: Path | None) -> bool:
    """The model as it was before this run was interrupted is still in memory."""
    return state.runs.preview is not None and path is not None and state.runs.preview.name == path.name


def why_not_view(state: AppState, path: Path | None, *, has_checkpoint: bool) -> str:
    """Why the model of an interrupted run cannot be viewed, in a sentence; empty when it can."""
    if has_preview(state, path) or (path is not None and has_checkpoint):
        return ""
    return "It has neither a preview nor a checkpoint."


def view_model(state: AppState, path: Path | None) -> None:
    """Show the model of an interrupted run: as it was last seen, else as its last checkpoint has it."""
    if has_preview(state, path):
        _show_preview(state)
    elif path is not None and state.runs.reconstruction.is_alive:
        second_actions.open_second(state, path)
    elif path is not None:
        actions.open_path(state, path)


def view_interrupted(state: AppState) -> None:
    """The same of the run that this window made last."""
    run = state.runs.reconstruction
    if not why_not_view(state, run.run_path, has_checkpoint=run.has_checkpoint):
        view_model(state, run.run_path)


def _show_preview(state: AppState) -> None:
    """Show the model as it was last seen before its run was interrupted."""
    preview = state.runs.preview
    if preview is None:
        return

    def show() -> None:
        state.scene.model = preview

    if state.runs.reconstruction.is_alive and state.scene.model is not None:
        state.scene.second = Second(model=preview)
    else:
        actions.leave(state, show)
