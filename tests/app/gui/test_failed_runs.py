"""What the window says of a reconstruction that has failed."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from app.gui.actions import job_actions, run_actions
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels
from app.gui.update.jobs import start_due
from app.gui.update.update import update
from app.runs.job import Failed
from app.runs.structuring import NO_DEPTH
from renderer.gaussians import DynamicGaussians
from renderer.readers.clip_options import ClipOptions
from tests.app.gui.conftest import FakeJob
from tests.app.gui.settling import follow_run, show_live

MakeFake = Callable[[object], FakeJob]


@pytest.mark.parametrize(
    ("left", "said"), [("nothing", "Nothing"), ("run", "no checkpoint"), ("checkpoint", "last checkpoint")]
)
def test_a_failure_says_what_can_be_done(
    state: AppState, make_job: MakeFake, model: DynamicGaussians, left: str, said: str
) -> None:
    job_actions.start_reconstruction(state)
    start_due(state, make_job)
    run = state.runs.reconstruction
    assert isinstance(run.job, FakeJob)
    assert run.run_path is not None
    show_live(state, model)
    if left != "nothing":
        run.run_path.mkdir(parents=True)
        (run.run_path / "run.json").touch()
    if left == "checkpoint":
        (run.run_path / "checkpoint-0000004.safetensors").touch()
    run.job.inbox = [Failed("killed")]
    update(state, Channels(), 0.1)
    follow_run(state)
    assert said in run.way_out
    assert job_actions.can_continue(state) == (left != "nothing")
    assert run_actions.has_preview(state, run.run_path)
    state.scene.model = None
    run_actions.view_model(state, run.run_path)
    assert state.scene.model is not None
    assert state.scene.model.model is model


@pytest.mark.parametrize("reason", [f"{NO_DEPTH}: it only turns", "No space left on device"])
def test_without_depth_from_motion_another_depth_is_the_way_out(
    state: AppState, make_job: MakeFake, reason: str
) -> None:
    state.source.options = ClipOptions(depth="motion")
    job_actions.start_reconstruction(state)
    start_due(state, make_job)
    run = state.runs.reconstruction
    assert isinstance(run.job, FakeJob)
    run.job.inbox = [Failed(reason)]
    update(state, Channels(), 0.1)
    follow_run(state)
    assert ("choose Guessed (no scale) for Depth" in run.way_out) == reason.startswith(NO_DEPTH)
    assert "start again" in run.way_out
