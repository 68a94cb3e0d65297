"""Renaming and deleting runs of the open clip, after a question, as functions on the state. No ImGui."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from app.enhancement.settable import LONGEST_NAME
from app.files.legible import legible
from app.gui.actions import actions, arriving, run_actions, second_actions
from app.gui.state.app_state import AppState
from app.gui.state.reconstruction import RunQuestion
from app.gui.work.background import Failure
from app.gui.work.changing_runs import ChangeRequest
from app.gui.work.runs import ListedRun
from app.runs.run_changes import Footprint, folder_name


def why_not_change(state: AppState, run: ListedRun) -> str:
    """Why it can be neither renamed nor deleted now, in a sentence; empty when it can."""
    if run_actions.is_in_training(state, run):
        return "It is in training."
    if state.runs.is_queued(run.path):
        return "It is queued: remove it from the queue first."
    if not is_shown(state, run.path):
        return ""
    if state.runs.reconstruction.is_alive:
        return "Its model is shown until the run in training has a first one."
    return "Save or undo the edits of its model first." if state.editing.is_unsaved else ""


def is_shown(state: AppState, path: Path) -> bool:
    """As the first model, or as the run of the Reconstruction panel."""
    model = state.scene.model
    return path in (state.runs.reconstruction.run_path, model.path if model is not None else None)


def shown_run(state: AppState) -> ListedRun | None:
    """Of the list, the one that is shown."""
    runs = state.runs.found.runs if state.runs.found is not None else ()
    return next((run for run in runs if is_shown(state, run.path)), None)


def can_change_shown(state: AppState) -> bool:
    run = shown_run(state)
    return run is not None and not why_not_change(state, run)


def ask_name(state: AppState, run: ListedRun | None = None) -> None:
    """Which name it shall have; None: the one that is shown."""
    run = run or shown_run(state)
    if run is not None and not why_not_change(state, run):
        state.runs.question = RunQuestion(run.path, run.path.name)


def ask_delete(state: AppState, run: ListedRun | None = None) -> None:
    """Whether it shall go; None: the one that is shown."""
    run = run or shown_run(state)
    if run is not None and not why_not_change(state, run):
        state.runs.question = RunQuestion(run.path)


def type_name(state: AppState, name: str) -> None:
    if state.runs.question is not None:
        state.runs.question.name = name[:LONGEST_NAME]


def why_not_name(question: RunQuestion) -> str:
    """In a sentence; empty for a name that can be tried."""
    return "" if folder_name(question.name or "") else "Type a name with letters or digits."


def footprint_wish(state: AppState) -> Path | None:
    """The folder whose size is asked for: of what may be deleted."""
    question = state.runs.question
    return question.path if question is not None and question.name is None else None


def take_footprint(state: AppState, path: Path, answer: Footprint) -> None:
    if state.runs.question is not None and state.runs.question.path == path:
        state.runs.question.footprint = answer


def answer(state: AppState, *, agreed: bool) -> None:
    """The question is gone, and what it asked is done in the background or not at all."""
    question, state.runs.question = state.runs.question, None
    if question is not None and agreed and not (question.name is not None and why_not_name(question)):
        state.window.wishes += (ChangeRequest(question.path, question.name, question.is_for_good),)


def take_changed(state: AppState, request: ChangeRequest, answer: Path | Failure | None) -> None:
    """Say it, and show the run by its new name, or its clip without it."""
    name = legible(request.path.name)
    if isinstance(answer, Failure):
        verb = "deleted" if request.name is None else "renamed"
        actions.fail(state, f"the run {name} was not {verb}: {answer.message}")
        return
    if answer == request.path:
        return
    gone = f"deleted {name}" if request.for_good else f"moved {name} to the bin"
    now = f"the run {name} is now called {legible(answer.name)}" if answer is not None else gone
    actions.announce(state, now)
    actions.use_settings(state, state.settings.moved(request.path, answer))
    if answer is None and (found := state.runs.found) is not None:
        # The list is made again seconds later: until then the run could be opened from it.
        state.runs.found = replace(found, runs=tuple(run for run in found.runs if run.path != request.path))
    second = state.scene.second.model
    if second is not None and second.path == request.path:
        second_actions.close_second(state)
        if answer is not None:
            second_actions.open_second(state, answer)
    if is_shown(state, request.path):
        _follow(state, request.path, answer)


def _follow(state: AppState, before: Path, path: Path | None) -> None:
    """What is shown, and so the session, is of the run at its new place, or of its clip alone."""
    clip, begun = state.source.clip, state.runs.reconstruction.request
    if clip is None:
        return
    if path is None:
        arriving.show_without_run(state, clip)
        return
    # At once: the session may be saved before the run is open again.
    if state.source.path == before:
        state.source.path = path
    if begun is not None and begun.run_path == before:
        state.runs.reconstruction.request = replace(begun, run_path=path)
    if state.source.opening is None:
        actions.open_run(state, path)
