"""What a reconstruction is doing and how long the rest of it takes, in a line."""

from __future__ import annotations

from typing import Final

from app.files.legible import capital, grouped
from app.gui.state.app_state import AppState
from app.gui.state.reconstruction import Reconstruction
from app.kernels.progress import rounded
from renderer.train.events import Finishing, Preparing, Progress

STATUS: Final = {
    "none": "", "starting": "Starting…", "running": "Reconstructing", "paused": "Paused",
    "finished": "Finished", "failed": "Stopped", "cancelled": "Interrupted",
    "elsewhere": "Training elsewhere",
}  # fmt: skip
CANCELLING: Final = "Cancelling…"
FIRST_STEP: Final = "Preparing the first iteration…"
COMPILING: Final = "Compiling once…"
LATE: Final = "longer than expected"
KEEPS: Final = "The iterations that are done are kept: Continue resumes from there."
"""Of a run that is cancelled."""
LONG_STEP: Final = 5.0
"""Seconds after which a first step is known to compile: others take a fraction of one."""


def doing(state: AppState) -> str:
    """Of the run that is shown."""
    run = state.runs.reconstruction
    if run.cancelling and run.is_alive:
        return CANCELLING
    match run.status:
        case "starting" if run.preparing is not None:
            return _preparing(run.preparing)
        case "running" if run.finishing is not None:
            return _finishing(run.finishing, state.window.now - run.finishing_at)
        case "running":
            return _first(state, run) if run.progress is None else _step(run.progress)
        case "paused" if run.progress is not None:
            return f"Paused at iteration {_steps(run.progress)}"
        case status:
            return STATUS[status]


def share_done(run: Reconstruction) -> float | None:
    """Of what it is doing; None: not known, or all that is counted is done."""
    if run.status == "starting" and run.preparing is not None:
        return run.preparing.done / run.preparing.total if run.preparing.total else None
    if run.progress is None or (run.finishing is not None and run.is_alive):
        return None
    return run.progress.iteration / run.progress.iterations


def _preparing(stage: Preparing) -> str:
    count = f" · {grouped(stage.done)} of {grouped(stage.total)}" if stage.total else ""
    if stage.seconds_left is None:
        return f"{capital(stage.stage)}{count}"
    is_late = stage.seconds_left == 0 and stage.done < stage.total
    return f"{capital(stage.stage)}{count} · {LATE if is_late else f'{rounded(stage.seconds_left)} left'}"


def _finishing(stage: Finishing, seconds: float) -> str:
    """It has gone on for so long: what was left when it began has become less, or was too little; 0: nobody
    has told."""
    if stage.seconds_left == 0:
        return f"{capital(stage.stage)}…"
    left = stage.seconds_left - seconds
    return f"{capital(stage.stage)} · {f'{rounded(left)} left' if left > 0 else LATE}"


def _first(state: AppState, run: Reconstruction) -> str:
    waited = state.window.now - run.started_at
    return COMPILING if state.lacks("training") or waited > LONG_STEP else FIRST_STEP


def _step(progress: Progress) -> str:
    return f"Iteration {_steps(progress)} · {rounded(progress.seconds_left)} left"


def _steps(progress: Progress) -> str:
    return f"{grouped(progress.iteration)} of {grouped(progress.iterations)}"
