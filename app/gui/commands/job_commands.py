"""The commands of reconstructions: the running one, and the queue."""

from __future__ import annotations

from app.gui.actions import changing_runs, job_actions, queue_actions, run_actions
from app.gui.commands.command import Command, Needs, Section, menu
from app.gui.state.app_state import AppState


def job_sections() -> tuple[Section, ...]:
    making = (
        Command("Reconstruct", job_actions.start_reconstruction, ("Ctrl+R",),
                text="reconstruct with the current settings: now, or after those in the queue",
                applies=Needs(job_actions.why_not_reconstruct),
                refuse=job_actions.refuse,
                synonyms=("train", "3d", "gaussian", "splat", "model", "run", "start", "depth", "stereo",
                          "calibration", "quality", "iterations", "training", "nerf", "mesh", "settings")),
        Command("Pause reconstruction", job_actions.toggle_pause, ("Ctrl+P",),
                text="pause or resume training", ticked=lambda s: s.runs.reconstruction.can_resume,
                applies=lambda s: s.runs.reconstruction.can_pause or s.runs.reconstruction.can_resume,
                synonyms=("hold", "resume", "training")),
        Command("Cancel reconstruction", job_actions.cancel, ("Ctrl+Shift+X",),
                text="stop training; the iterations that are done are kept",
                applies=lambda s: s.runs.reconstruction.is_alive, synonyms=("abort", "stop", "training")),
    )  # fmt: skip
    ended = (
        Command("Continue the interrupted run", job_actions.continue_reconstruction,
                text="from its last checkpoint", applies=job_actions.can_continue),
        Command("View the interrupted run", run_actions.view_interrupted,
                text="show the model as last seen", applies=_can_view),
        Command("Rename the run…", changing_runs.ask_name, text="give the run that is shown another name",
                applies=changing_runs.can_change_shown, synonyms=("name", "folder")),
        Command("Delete the run…", changing_runs.ask_delete,
                text="delete the run that is shown, after a question",
                applies=changing_runs.can_change_shown, synonyms=("remove", "bin", "trash", "disk")),
    )  # fmt: skip
    waiting = (
        Command("Start the queue", queue_actions.wake,
                text="run the reconstructions queued in an earlier session",
                applies=queue_actions.sleeps),
        Command("Move the last to the front", queue_actions.last_to_front,
                text="move the last of the queue to its front", applies=lambda s: len(s.runs.queue) > 1),
        Command("Empty the queue", queue_actions.empty,
                text="remove all queued reconstructions", applies=lambda s: bool(s.runs.queue)),
    )  # fmt: skip
    return menu("Reconstruct", making, ended, waiting)


def _can_view(state: AppState) -> bool:
    run = state.runs.reconstruction
    ended = run.status in ("failed", "cancelled")
    return ended and not run_actions.why_not_view(state, run.run_path, has_checkpoint=run.has_checkpoint)
