"""Starts the reconstruction whose turn has come, in another process."""

from __future__ import annotations

from collections.abc import Callable

from app.gui.actions import actions, queue_actions
from app.gui.state.app_state import AppState
from app.gui.state.reconstruction import Reconstruction
from app.runs.job import TrainingJob
from app.runs.train_run import TrainRequest

MakeJob = Callable[[TrainRequest], TrainingJob]


def start_due(state: AppState, make_job: MakeJob) -> None:
    """Once a frame: the next one, when a person has just asked for one, or when the one before has ended in
    whatever way; once its clip is open, unless one is under way."""
    asked, state.runs.starts = state.runs.starts, False
    draft, first = state.runs.reconstruction, state.runs.next_waiting
    if draft.is_alive or first is None or first.clip is None:
        return
    if not asked and (draft.job is not None or queue_actions.why_held(state)):
        return
    state.runs.queue = tuple(each for each in state.runs.queue if each is not first)
    job = make_job(first.request)
    state.runs.reconstruction = Reconstruction(
        config=draft.config,
        input=draft.input,
        d_factor=draft.d_factor,
        name=draft.name,
        status="starting",
        job=job,
        clip=first.request.part.of(first.clip),
        request=first.request,
        told=first.told,
    )
    job.start()
    actions.say(state, f"reconstruction of {first.clip.name} started: {first.request.run_path.name}")
