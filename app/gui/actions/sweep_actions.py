"""What is done with a sweep that is shown: axes, one job, its image, and its setting."""

from __future__ import annotations

from app.gui.actions import actions, enhancement_actions
from app.gui.state.app_state import AppState
from app.gui.work.background import Failure
from app.gui.work.swept import SweptImage, SweptJob


def choose_axes(state: AppState, across: str, up: str) -> None:
    """Of the diagram of all jobs."""
    state.reports.axes = (across, up)


def choose_job(state: AppState, job: SweptJob | None) -> None:
    """To see its image."""
    state.reports.job, state.reports.image = job, None


def take_image(state: AppState, job: SweptJob, answer: SweptImage | Failure) -> None:
    if job is not state.reports.job:
        return
    if isinstance(answer, Failure):
        actions.say(state, f"the image of the job cannot be shown: {answer.message}")
    else:
        state.reports.image = answer


def use_params(state: AppState, job: SweptJob) -> None:
    """Enhance by the job's settings from now on; one step of undo."""
    assert job.params is not None
    enhancement_actions.enhance_by(state, job.params, job.scope, job.pixels, job.setting)


def open_run(state: AppState, job: SweptJob) -> None:
    """The reconstruction of a training job."""
    assert job.run is not None
    actions.open_path(state, job.run)
