"""A session and the runs of its clip: it goes on with another one, and with one of another name."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from app.gui.actions import (
    actions,
    browse_actions,
    changing_runs,
    edit_actions,
    job_actions,
    notes_actions,
    session_actions,
)
from app.gui.session_file import mended_session
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels
from app.gui.work.changing_runs import ChangeRequest
from app.gui.work.settings import Places
from assets import phantom_path
from renderer.gaussians import DynamicGaussians
from tests.app.gui.test_opening import make_run
from tests.app.gui.test_session import opened_state, turn

Window = tuple[AppState, Channels]


def settle(window: Window) -> None:
    for _ in range(5):
        turn(*window)


@pytest.fixture
def clip(tmp_path: Path) -> Path:
    return Path(shutil.copytree(phantom_path(), tmp_path / "clips" / "liver"))


@pytest.fixture
def run(places: Places, clip: Path, model: DynamicGaussians) -> Path:
    return make_run(places.runs / "one", clip, model).path


@pytest.fixture
def file(places: Places) -> Path:
    return places.pictures / "a.vesselsplat"


@pytest.fixture
def noted(places: Places, run: Path, file: Path) -> Window:
    """A saved session of the run, with a note since."""
    window = opened_state(places, run)
    session_actions.save_to(window[0], file)
    settle(window)
    notes_actions.write_notes(window[0], "polyp")
    settle(window)
    return window


def test_a_session_goes_on_in_its_file_with_another_run_of_its_clip(
    noted: Window, places: Places, clip: Path, file: Path, model: DynamicGaussians
) -> None:
    state, other = noted[0], make_run(places.runs / "two", clip, model).path
    actions.open_run(state, other)
    settle(noted)
    assert (state.session.leaving, state.session.path, state.source.path) == (None, file, other)
    assert session_actions.look_for_changes(state)
    session_actions.save(state)
    settle(noted)
    session, _ = mended_session(file)
    assert (session.notes, session.run and session.run.found(file)) == ("polyp", other)


def test_a_run_of_another_clip_ends_the_session_after_a_question(
    noted: Window, places: Places, tmp_path: Path, model: DynamicGaussians
) -> None:
    state, other = noted[0], Path(shutil.copytree(phantom_path(), tmp_path / "other" / "liver"))
    actions.open_run(state, make_run(places.runs / "two", other, model).path)
    settle(noted)
    assert state.session.leaving is not None
    session_actions.answer(state, "discard")
    settle(noted)
    assert (state.session.path, state.session.is_unsaved) == (None, False)


def renamed(window: Window, run: Path) -> Path:
    path = run.rename(run.with_name("two"))
    changing_runs.take_changed(window[0], ChangeRequest(run, "two"), path)
    return path


def test_a_session_goes_on_with_a_run_that_is_renamed(
    noted: Window, places: Places, run: Path, file: Path
) -> None:
    state, path = noted[0], renamed(noted, run)
    session_actions.save(state)  # At once: before the run is open again.
    settle(noted)
    assert (state.session.leaving, state.session.path, state.window.banner) == (None, file, None)
    assert state.scene.model is not None
    assert (state.scene.model.path, state.source.path, state.runs.reconstruction.run_path) == (path,) * 3
    again = opened_state(places, file)[0]
    assert (again.source.path, again.session.notes, again.window.banner) == (path, "polyp", None)
    assert again.scene.model is not None


def test_a_rename_is_a_change_of_a_session_that_has_no_other(noted: Window, run: Path) -> None:
    state = noted[0]
    session_actions.save(state)
    settle(noted)
    assert not session_actions.look_for_changes(state)
    renamed(noted, run)
    settle(noted)
    assert session_actions.look_for_changes(state)


def test_a_session_goes_on_with_the_clip_of_a_run_that_is_deleted(
    noted: Window, places: Places, clip: Path, run: Path, file: Path
) -> None:
    state = noted[0]
    shutil.rmtree(run)
    changing_runs.take_changed(state, ChangeRequest(run, None), None)
    session_actions.save(state)
    settle(noted)
    assert (state.scene.model, state.source.path, state.source.content) == (None, clip, "clip")
    assert (state.session.leaving, state.session.path) == (None, file)
    again = opened_state(places, file)[0]
    assert (again.source.path, again.session.notes, again.window.banner) == (clip, "polyp", None)


def test_a_session_whose_run_is_gone_says_so_and_asks_where_it_is(
    noted: Window, places: Places, clip: Path, run: Path, file: Path
) -> None:
    state = noted[0]
    state.source.path = clip  # As after training in the window.
    edit_actions.toggle(state)
    edit_actions.select_all(state)
    edit_actions.hide(state)
    assert state.editing.is_unsaved
    session_actions.save(state)
    settle(noted)
    moved = run.rename(run.with_name("moved"))
    window = opened_state(places, file)
    again = window[0]
    assert again.window.banner is not None
    assert "expected the reconstruction one" in again.window.banner.message.lower()
    assert "liver is shown without it" in again.window.banner.message
    assert again.window.banner.find is not None
    again.window.banner.find()
    asked = actions.taken_choice(again)
    assert asked is not None
    browse_actions.chosen(again, asked, moved)
    settle(window)
    assert again.scene.model is not None
    assert (again.scene.model.path, again.window.banner) == (moved, None)
    assert again.editing.is_unsaved


def test_a_session_opened_beside_a_training_keeps_what_it_does_not_show(
    places: Places, clip: Path, run: Path, file: Path, tmp_path: Path
) -> None:
    first = opened_state(places, run)
    job_actions.choose_method(first[0], "vesselsplat", 6000)
    job_actions.choose_input(first[0], "enhanced")
    notes_actions.write_notes(first[0], "polyp")
    session_actions.save_to(first[0], file)
    settle(first)
    before = file.read_bytes()
    window = opened_state(places, Path(shutil.copytree(clip, tmp_path / "other" / "liver")))
    state, training = window[0], window[0].runs.reconstruction
    training.status, training.config = "running", replace(training.config, iterations=500)
    actions.open_path(state, file)
    settle(window)
    assert (training.config.iterations, training.input) == (6000, "enhanced")
    assert state.window.banner is not None
    assert "not shown while another is in training" in state.window.banner.message
    assert not session_actions.loses_case(state)
    session_actions.save(state)
    settle(window)
    asked = actions.taken_choice(state)
    assert (asked is not None and asked.purpose, file.read_bytes()) == ("session", before)


def test_what_a_crash_left_stays_where_it_is_opened_beside_a_training(
    noted: Window, places: Places, clip: Path, file: Path, tmp_path: Path
) -> None:
    session_actions.save(noted[0])
    settle(noted)
    left = file.rename(places.config / "declined.vesselsplat")
    before = left.read_bytes()
    window = opened_state(places, Path(shutil.copytree(clip, tmp_path / "other" / "liver")))
    window[0].runs.reconstruction.status = "running"
    actions.open_path(window[0], left)
    settle(window)
    assert window[0].window.banner is not None
    assert "not shown while another is in training" in window[0].window.banner.message
    assert left.read_bytes() == before
