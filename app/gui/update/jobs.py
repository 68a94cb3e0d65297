"""Starts the reconstruction whose turn has come, in another process, and follows what it says."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace

from app.errors import UserError, sentence
from app.files.legible import without_flags
from app.gui.actions import actions, job_actions, queue_actions
from app.gui.state.app_state import AppState
from app.gui.state.reconstruction import Ending, Reconstruction
from app.gui.work.runs import LeftRequest
from app.runs.job import Cancelled, Failed, Paused, Resumed, TrainingJob
from app.runs.memory import told
from app.runs.train_run import TrainRequest
from app.runs.wall_clock import in_all
from renderer.clip import ClipError
from renderer.train.events import (
    Evaluated,
    Finished,
    Finishing,
    Planned,
    Preparing,
    Progress,
    Started,
    Warned,
)

log = logging.getLogger(__name__)
LONGEST_END = 60.0
"""Seconds after which the process of a run that has ended is not waited for."""
MakeJob = Callable[[TrainRequest], TrainingJob]


def start_due(state: AppState, make_job: MakeJob) -> None:
    """Once a frame: the next one, when a person has just asked for one, or when the one before has ended in
    whatever way and its process has; once its clip is open, unless one is under way."""
    if state.runs.ending is not None:
        return
    asked, state.runs.starts = state.runs.starts, False
    draft, first = state.runs.reconstruction, state.runs.next_waiting
    if draft.is_alive or first is None or first.clip is None:
        return
    if not asked and (draft.job is not None or queue_actions.why_held(state)):
        return
    state.runs.queue = tuple(each for each in state.runs.queue if each is not first)
    try:
        clip, job = first.request.part.of(first.clip), make_job(first.request)
        job.start()
    except (UserError, ClipError, OSError) as error:
        actions.fail(state, f"{first.request.run_path.name} was not started: {sentence(error)}")
        return
    state.runs.reconstruction = Reconstruction(
        config=draft.config,
        input=draft.input,
        kept=draft.kept,
        name=draft.name,
        status="starting",
        started_at=state.window.now,
        job=job,
        clip=clip,
        request=first.request,
        told=first.told,
    )
    actions.say(state, f"reconstruction of {first.clip.name} started: {first.request.run_path.name}")


def follow_job(state: AppState) -> None:
    """Once a frame: hear what it says; when it has ended, give it back."""
    _follow(state)
    _close_ended(state)


def _close_ended(state: AppState) -> None:
    """Once its process has ended, which takes a while on a busy computer: the window must not wait for it."""
    ending = state.runs.ending
    if ending is not None and (ending.job.has_gone or state.window.now - ending.since > LONGEST_END):
        ending.job.close()
        state.runs.ending = None


def _follow(state: AppState) -> None:
    job = state.runs.reconstruction.job
    if job is None:
        return
    for event in job.poll():
        _hear(state, event)
    if not state.runs.reconstruction.is_alive:
        if state.scene.model is not None and state.scene.model.live:
            state.runs.preview = state.scene.model
        path = state.runs.reconstruction.run_path
        state.runs.reconstruction.ended = LeftRequest(path) if path is not None else None
        state.runs.reconstruction.job, state.runs.ending = None, Ending(job, state.window.now)
    elif (model := job.latest_model()) is not None:
        job_actions.show_live_model(state, model)


def _hear(state: AppState, event: object) -> None:
    """What one message of the job changes."""
    run = state.runs.reconstruction
    match event:
        case Preparing():
            run.preparing = event
        case Planned():
            run.planned = told(event)
        case Started():
            run.started, run.status, run.preparing = event, "running", None
            run.started_at = state.window.now
            # What was done after the checkpoint is done again.
            run.told = run.told.until(event.iteration)
        case Progress():
            run.progress = event
            run.told = replace(run.told, progress=(*run.told.progress, event))
        case Finishing():
            run.finishing, run.finishing_at = event, state.window.now
        case Evaluated():
            run.told = replace(run.told, evaluated=(*run.told.evaluated, event))
        case Warned():
            run.warnings.append(event.message)
            actions.say(state, event.message)
        case Paused():
            run.status = "paused"
        case Resumed():
            run.status = "running"
        case Finished():
            run.status = "finished"
            if run.progress is not None:
                # What came after the last step took its time, too.
                run.progress = replace(run.progress, wall_seconds=event.wall_seconds)
            job_actions.show_finished_model(state, event.model)
            actions.announce(
                state, f"reconstruction finished: {in_all(event.wall_seconds, event.seconds, '.0f')}"
            )
        case Cancelled():
            run.status = "cancelled"
            begun = run.iteration > 0
            actions.announce(state, f"reconstruction cancelled{'; Continue resumes it' if begun else ''}")
        case Failed():
            reason = without_flags(event.reason)
            run.status, run.failure = "failed", reason
            log.error("training failed: %s\n%s", event.reason, event.details)
            actions.fail(state, f"the reconstruction failed: {reason}")
