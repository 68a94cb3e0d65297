"""Edits of a model, and another one that a reconstruction makes meanwhile: nothing edited is lost."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from app.gui.actions import edit_actions, job_actions, session_actions
from app.gui.state.app_state import AppState
from app.gui.update.jobs import start_due
from app.gui.work.settings import Places
from app.runs.job import Failed
from assets import phantom_path
from renderer.gaussians import DynamicGaussians
from renderer.splat_files import write_splats
from renderer.train.events import Finished, Started
from tests.app.gui.conftest import FakeJob, make_model
from tests.app.gui.test_opening import make_run
from tests.app.gui.test_session import opened_state, turn
from tests.app.gui.test_session_runs import Window, settle


@pytest.fixture
def edited(places: Places, tmp_path: Path, model: DynamicGaussians) -> tuple[Window, FakeJob, Path]:
    """A run with an edit that is not saved, made while another one starts."""
    clip = Path(shutil.copytree(phantom_path(), tmp_path / "liver"))
    run = make_run(places.runs / "one", clip, model).path
    window, job = opened_state(places, run), FakeJob()
    state = window[0]
    job_actions.start_reconstruction(state)
    start_due(state, lambda request: job)
    edit_actions.toggle(state)
    edit_actions.select_all(state)
    edit_actions.hide(state)
    return window, job, run


def kept_run(state: AppState, places: Places) -> Path | None:
    session = session_actions.snapshot(state, places.pictures)
    return session.run and session.run.found(places.pictures / "a.vesselsplat")


def test_a_preview_waits_until_edits_are_saved(edited: tuple[Window, FakeJob, Path], places: Places) -> None:
    window, job, run = edited
    state = window[0]
    job.inbox, job.model = [Started(0, 100, 30, ())], make_model()
    settle(window)
    assert state.editing.is_unsaved
    assert state.scene.model is not None
    assert (state.scene.model.path, job_actions.waits_for_edits(state)) == (run, True)
    assert kept_run(state, places) == run
    edit_actions.save(state)
    turn(*window)
    window[1].edits.run_waiting()
    settle(window)
    assert not state.editing.is_unsaved
    edit_actions.toggle(state)
    settle(window)
    assert (state.scene.model.live, job_actions.waits_for_edits(state)) == (True, False)


def test_a_finished_model_waits_until_edits_are_left_and_then_is_edited_in_peace(
    edited: tuple[Window, FakeJob, Path], places: Places, tmp_path: Path
) -> None:
    window, job, run = edited
    state, made = window[0], window[0].runs.reconstruction.run_path
    assert made is not None
    make_run(made, tmp_path / "liver", make_model())
    job.inbox = [Started(0, 100, 30, ()), Finished(100, 2.0, make_model())]
    settle(window)
    assert state.editing.is_unsaved
    assert kept_run(state, places) == run
    edit_actions.undo(state)
    edit_actions.toggle(state)
    settle(window)
    assert state.editing.run_path == made != run
    edit_actions.toggle(state)
    edit_actions.select_all(state)
    edit_actions.hide(state)
    settle(window)
    edit_actions.toggle(state)
    turn(*window)
    settle(window)
    assert state.editing.is_unsaved
    assert kept_run(state, places) == made


def test_edits_come_back_with_their_run_where_the_other_one_fails(
    edited: tuple[Window, FakeJob, Path], places: Places, tmp_path: Path
) -> None:
    window, job, run = edited
    window[0].source.path = tmp_path / "liver"  # As after training in the window.
    job.inbox = [Failed("no depth", "")]
    settle(window)
    assert not window[0].runs.reconstruction.is_alive
    file = tmp_path / "a.vesselsplat"
    session_actions.save_to(window[0], file)
    settle(window)
    again = opened_state(places, file)
    settle(again)
    assert (again[0].editing.run_path, again[0].editing.is_unsaved) == (run, True)


def test_edits_of_splats_are_kept_without_the_run_of_a_training(
    edited: tuple[Window, FakeJob, Path], places: Places, tmp_path: Path, model: DynamicGaussians
) -> None:
    (trained, _), splats = edited[0], tmp_path / "a.ply"
    write_splats(splats, model.raw)
    window = opened_state(places, splats)
    state = window[0]
    edit_actions.toggle(state)
    edit_actions.select_all(state)
    edit_actions.hide(state)
    state.runs.reconstruction = trained.runs.reconstruction
    assert state.editing.is_unsaved
    assert state.runs.reconstruction.run_path is not None
    assert session_actions.snapshot(state, places.pictures).run is None
