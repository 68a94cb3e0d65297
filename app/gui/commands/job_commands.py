"""The commands of reconstructions: the one that is made, and those that wait."""

from __future__ import annotations

from app.gui.actions import job_actions, queue_actions, run_actions
from app.gui.commands.command import Command, Section
from app.gui.state.app_state import AppState


def job_sections() -> tuple[Section, ...]:
    making = (
        Command("Reconstruct", job_actions.start_reconstruction, ("Ctrl+R",),
                text="reconstruct as it is set: at once, or after those before it",
                applies=lambda s: not job_actions.why_not_reconstruct(s)),
        Command("Pause reconstruction", job_actions.toggle_pause, ("Ctrl+P",),
                text="pause training, and resume it", ticked=lambda s: s.runs.reconstruction.can_resume,
                applies=lambda s: s.runs.reconstruction.can_pause or s.runs.reconstruction.can_resume),
        Command("Cancel reconstruction", job_actions.cancel, ("Ctrl+Shift+X",),
                text="end training; its last checkpoint is kept",
                applies=lambda s: s.runs.reconstruction.is_alive),
    )  # fmt: skip
    ended = (
        Command("Continue the run cut short", job_actions.continue_reconstruction,
                text="from its last checkpoint", applies=job_actions.can_continue),
        Command("Look at the run cut short", run_actions.look_at_present,
                text="the model as it was last seen", applies=_can_look),
    )  # fmt: skip
    waiting = (
        Command("Start what waits", queue_actions.wake,
                text="make what waits since an earlier session, each in its turn",
                applies=queue_actions.sleeps),
        Command("Move the last to the front", queue_actions.last_to_front,
                text="of those that wait, make the last one next", applies=lambda s: len(s.runs.queue) > 1),
        Command("Empty the queue", queue_actions.empty,
                text="make none of those that wait", applies=lambda s: bool(s.runs.queue)),
    )  # fmt: skip
    return tuple(Section("Reconstruct", commands) for commands in (making, ended, waiting))


def _can_look(state: AppState) -> bool:
    run = state.runs.reconstruction
    ended = run.status in ("failed", "cancelled")
    return ended and not run_actions.why_not_look(state, run.run_path, has_checkpoint=run.has_checkpoint)
