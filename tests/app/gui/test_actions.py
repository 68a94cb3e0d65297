from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from app.gui.actions import actions, arriving, enhancement_actions, history_actions, job_actions
from app.gui.state import run_words
from app.gui.state.app_state import AppState
from app.gui.update.jobs import start_due
from app.gui.work.opening import Opened
from app.gui.work.settings import load_settings
from app.runs.progress_log import TrainingLog
from app.runs.train_run import TrainRequest
from enhance import EnhanceParams
from enhance.vessel import VesselParams
from renderer.gaussians import DynamicGaussians
from renderer.train.events import Progress
from tests.app.gui.conftest import FakeJob, make_clip
from tests.app.gui.settling import keep_all, show_finished, show_live

MakeFake = Callable[[object], FakeJob]


def started(state: AppState, make_job: MakeFake) -> FakeJob:
    job_actions.start_reconstruction(state)
    start_due(state, make_job)
    assert isinstance(state.runs.reconstruction.job, FakeJob)
    return state.runs.reconstruction.job


def test_seeking_stays_within_the_clip(state: AppState) -> None:
    for wanted, got in ((3, 3), (-5, 0), (99, 5)):
        actions.seek(state, wanted)
        assert state.timeline.frame_index == got


def test_without_a_clip_nothing_moves(places) -> None:  # type: ignore[no-untyped-def]
    state = AppState(places)
    for act in (
        actions.toggle_play,
        actions.toggle_freeze,
        history_actions.undo,
        history_actions.redo,
        job_actions.cancel,
    ):
        act(state)
    actions.step(state, 1)
    assert (state.timeline.playing, state.timeline.frozen_index, state.timeline.frame_index) == (
        False,
        None,
        0,
    )


def test_a_frozen_picture_holds_its_frame_while_time_goes_on(state: AppState) -> None:
    actions.seek(state, 2)
    actions.toggle_freeze(state)
    actions.seek(state, 4)
    assert state.picture_request is not None
    assert state.picture_request.frame_index == 2
    assert state.time == pytest.approx(4 / 6)
    actions.toggle_freeze(state)
    assert state.picture_request is not None
    assert state.picture_request.frame_index == 4


def test_stepping_thaws_and_stops(state: AppState) -> None:
    actions.toggle_play(state)
    actions.toggle_freeze(state)
    actions.step(state, 1)
    assert (state.timeline.playing, state.timeline.frozen_index, state.timeline.frame_index) == (
        False,
        None,
        1,
    )


def test_white_light_asks_for_no_enhancement(state: AppState) -> None:
    enhancement_actions.white_light(state)
    assert state.picture_request is not None
    assert state.picture_request.params is None
    enhancement_actions.toggle_enhancement(state)
    assert state.picture_request.params == state.enhancement.params


def test_one_drag_is_one_step_of_undo(state: AppState) -> None:
    for d_factor in (1.1, 1.2, 1.3):  # The slider is held.
        enhancement_actions.set_params(state, replace(state.enhancement.params, d_factor=d_factor))
    enhancement_actions.settle_params(state)
    enhancement_actions.set_params(state, replace(state.enhancement.params, z=0.3))
    enhancement_actions.settle_params(state)
    seen = [state.enhancement.params]
    for _ in range(3):
        history_actions.undo(state)
        seen.append(state.enhancement.params)
    assert [(params.d_factor, params.z) for params in seen] == [
        (1.3, 0.3),
        (1.3, None),
        (None, None),
        (None, None),
    ]
    history_actions.redo(state)
    history_actions.redo(state)
    assert state.enhancement.params == seen[0]


def test_reset_can_be_undone_and_a_change_ends_redo(state: AppState) -> None:
    enhancement_actions.set_params(state, EnhanceParams(z=0.2))
    enhancement_actions.settle_params(state)
    enhancement_actions.reset_params(state)
    history_actions.undo(state)
    assert state.enhancement.params == EnhanceParams(z=0.2)
    enhancement_actions.set_params(state, EnhanceParams(z=0.9))
    enhancement_actions.settle_params(state)
    history_actions.redo(state)
    assert state.enhancement.params == EnhanceParams(z=0.9)


def test_reset_resets_all_but_the_method(state: AppState) -> None:
    assert not enhancement_actions.can_reset(state)
    for change in (
        {"params": VesselParams(strength=0.3)}, {"params": VesselParams(), "scope": "image"},
        {"pixels": "tissue"},
    ):  # fmt: skip
        for name, value in change.items():
            setattr(state.enhancement, name, value)
        assert enhancement_actions.can_reset(state)
        enhancement_actions.reset_params(state)
        chosen = state.enhancement
        assert (chosen.params, chosen.scope, chosen.pixels) == (VesselParams(), "automatic", "automatic")
        assert not enhancement_actions.can_reset(state)


def test_an_opened_clip_starts_a_session_and_is_remembered(state: AppState, tmp_path: Path) -> None:
    actions.seek(state, 4)
    state.timeline.frozen_index, state.timeline.playing = 4, True
    other = make_clip(tmp_path / "other", 3)
    arriving.show_opened(state, other.path, Opened(other, notices=("one stray file",)))
    assert state.source.clip is other
    assert (state.timeline.frame_index, state.timeline.frozen_index, state.timeline.playing) == (
        0,
        None,
        False,
    )
    keep_all(state)
    assert load_settings(state.places.settings_file).recent == (str(other.path),)
    assert "one stray file" in state.window.log


def test_opening_a_clip_leaves_a_running_reconstruction_alone(
    state: AppState, make_job: MakeFake, tmp_path: Path
) -> None:
    job = started(state, make_job)
    other = make_clip(tmp_path / "other", 3)
    arriving.show_opened(state, other.path, Opened(other))
    assert state.runs.reconstruction.job is job
    assert job.told == ["start"]


def test_the_request_holds_what_was_chosen(state: AppState, make_job: MakeFake) -> None:
    run = state.runs.reconstruction
    run.input, run.name = "enhanced", "my run / 1"
    run.config = replace(run.config, method="static", iterations=20)
    enhancement_actions.set_params(state, EnhanceParams(z=0.3, d_factor=2.0))
    request = started(state, make_job).request
    assert isinstance(request, TrainRequest)
    assert request.run_path == state.places.runs / "my-run-1"
    assert (request.config.method, request.config.iterations) == ("static", 20)
    assert request.input == "enhanced"
    assert request.enhance_params == EnhanceParams(z=0.3, d_factor=2.0)
    assert not request.resume


def test_a_taken_name_is_never_used_again(state: AppState, make_job: MakeFake) -> None:
    (state.places.runs / "same").mkdir(parents=True)
    state.runs.reconstruction.name = "same"
    request = started(state, make_job).request
    assert isinstance(request, TrainRequest)
    assert request.run_path.name == "same-2"


@pytest.mark.parametrize("name", ["../../escape", "/etc/x", "..", "", "   ", "a\\b"])
def test_a_name_never_leaves_the_runs_folder(state: AppState, make_job: MakeFake, name: str) -> None:
    state.runs.reconstruction.name = name
    request = started(state, make_job).request
    assert isinstance(request, TrainRequest)
    assert request.run_path.parent == state.places.runs
    assert request.run_path.name not in ("", ".", "..")


def test_words_go_to_the_job_only_when_they_mean_something(state: AppState, make_job: MakeFake) -> None:
    job = started(state, make_job)
    job_actions.pause(state)  # Still starting: there is nothing to pause yet.
    state.runs.reconstruction.status = "running"
    job_actions.resume(state)
    job_actions.pause(state)
    state.runs.reconstruction.status = "paused"
    job_actions.pause(state)
    job_actions.resume(state)
    assert run_words.doing(state) != "Cancelling…"
    job_actions.cancel(state)
    assert run_words.doing(state) == "Cancelling…"  # At once, while the step in hand is done.
    job_actions.resume(state)
    state.runs.reconstruction.status = "cancelled"
    assert run_words.doing(state) == "Interrupted"
    job_actions.cancel(state)
    assert job.told == ["start", "pause", "resume", "cancel"]


def test_continue_asks_for_what_was_begun_whatever_was_chosen_since(
    state: AppState, make_job: MakeFake
) -> None:
    first = started(state, make_job).request
    run = state.runs.reconstruction
    run.status, run.told = "cancelled", TrainingLog((Progress(1, 7, 0.5, 20.0, 1.0, 9.0, 30),))
    run.config = replace(run.config, iterations=7)
    enhancement_actions.set_params(state, EnhanceParams(z=0.9))
    assert job_actions.can_continue(state)
    job_actions.continue_reconstruction(state)
    start_due(state, make_job)
    job = state.runs.reconstruction.job
    assert isinstance(job, FakeJob)
    assert isinstance(first, TrainRequest)
    assert job.request == replace(first, resume=True)
    assert state.runs.reconstruction.told == run.told


def test_continue_is_of_the_run_s_own_clip_while_another_is_open(
    state: AppState, make_job: MakeFake, tmp_path: Path
) -> None:
    first = started(state, make_job).request
    state.runs.reconstruction.status = "failed"
    state.source.clip = make_clip(tmp_path / "other")
    job_actions.continue_reconstruction(state)
    (waiting,) = state.runs.queue
    assert isinstance(first, TrainRequest)
    assert (waiting.clip, waiting.request) == (None, replace(first, resume=True))


def test_what_a_reconstruction_lacks_is_said(state: AppState, tmp_path: Path) -> None:
    assert job_actions.why_not_reconstruct(state) == ""
    state.source.clip = make_clip(tmp_path / "flat", has_depth=False)
    assert "depth" in job_actions.why_not_reconstruct(state)
    state.source.clip = None
    assert "clip" in job_actions.why_not_reconstruct(state)


def test_the_live_preview_says_so_and_keeps_its_pivot(
    state: AppState, make_job: MakeFake, model: DynamicGaussians
) -> None:
    started(state, make_job)
    show_live(state, model)
    assert state.scene.model is not None
    assert state.scene.model.live
    first = state.scene.model
    state.runs.reconstruction.progress = Progress(50, 3000, 0.1, 20.0, 1.0, 9.0, 30)
    show_live(state, replace(model, raw=replace(model.raw, means=model.means * 2)))
    assert state.scene.model.distance == first.distance == pytest.approx(50.0)
    assert state.scene.model.iteration == 50
    show_finished(state, model)
    assert not state.scene.model.live


def test_unlinked_the_view_keeps_its_time(state: AppState) -> None:
    actions.seek(state, 3)
    actions.toggle_link(state)
    actions.seek(state, 0)
    assert state.time == pytest.approx(0.5)
    actions.seek_view(state, 0.9)
    assert (state.time, state.timeline.frame_index) == (pytest.approx(0.9), 0)
    actions.toggle_link(state)
    actions.seek_view(state, 0.5)
    assert state.timeline.frame_index == 3


def test_acknowledging_is_remembered(places) -> None:  # type: ignore[no-untyped-def]
    state = AppState(places)
    assert not state.settings.acknowledged
    actions.acknowledge(state)
    keep_all(state)
    assert load_settings(places.settings_file).acknowledged


def test_settings_that_cannot_be_kept_are_no_disaster(state: AppState) -> None:
    state.places.config.write_text("a file where a folder should be")
    actions.acknowledge(state)
    keep_all(state)
    assert state.settings.acknowledged
    assert any("settings" in line for line in state.window.log)


def test_a_model_without_pictures_is_alone(
    state: AppState, model: DynamicGaussians, make_job: MakeFake
) -> None:
    started(state, make_job)
    show_live(state, model)
    assert not state.is_model_alone
    state.source.clip = None
    assert state.is_model_alone
    state.scene.model = None
    assert not state.is_model_alone
