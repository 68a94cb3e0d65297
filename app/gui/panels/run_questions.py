"""What is asked before a run is renamed or deleted."""

from __future__ import annotations

from functools import partial

from app.files.legible import grouped, legible
from app.gui.actions import changing_runs
from app.gui.state.app_state import AppState
from app.gui.state.reconstruction import RunQuestion
from app.gui.style.asking import ask, ask_name
from app.runs.run_changes import Footprint, folder_name

RENAME, DELETE = "Rename the run", "Delete the run?"
BIN = "It goes to the system's bin, from which it can be restored."
FOR_GOOD = "There is no bin for it here: it is deleted for good."


def draw_run_question(state: AppState) -> None:
    """Over everything, while it stands."""
    asked = state.runs.question
    if asked is None:
        return
    if asked.name is None:
        _draw_delete(state, asked)
    else:
        _draw_rename(state, asked, asked.name)


def _draw_delete(state: AppState, asked: RunQuestion) -> None:
    known = FOR_GOOD if asked.is_for_good else BIN
    # A line either way: the buttons stay where they are.
    said = (legible(str(asked.path)), held(asked.footprint), known if asked.footprint is not None else " ")
    if reply := ask(DELETE, said, ("Delete", "Keep")):
        changing_runs.answer(state, agreed=reply == "Delete")


def held(footprint: Footprint | None) -> str:
    """What the folder holds, in words."""
    if footprint is None:
        return "Measuring the folder…"
    files = f"{grouped(footprint.files)} file{'s' * (footprint.files != 1)}"
    return f"{files}, {footprint.size / 1e6:,.1f} MB, with everything that was exported into it."


def _draw_rename(state: AppState, asked: RunQuestion, name: str) -> None:
    becomes = folder_name(name)
    told = f"Becomes {becomes}" if becomes and becomes != name else ""
    take, why_not = partial(changing_runs.type_name, state), partial(changing_runs.why_not_name, asked)
    agreed = ask_name(RENAME, "Name of the folder", name, take, why_not, told)
    if agreed is not None:
        changing_runs.answer(state, agreed=agreed)
