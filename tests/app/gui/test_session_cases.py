"""Sessions beside several clips, runs and cases: nothing of one is put on another, and nothing is lost."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from app.gui.actions import (
    actions,
    browse_actions,
    changing_runs,
    clip_actions,
    depth_actions,
    enhancement_actions,
    job_actions,
    notes_actions,
    session_actions,
    summary_actions,
)
from app.gui.actions.session_actions import snapshot
from app.gui.session_file import MOST_ITEMS, SessionSource, mended_session, write_session
from app.gui.state.app_state import AppState
from app.gui.state.summary import Item
from app.gui.update.channels import Channels
from app.gui.work.changing_runs import ChangeRequest
from app.gui.work.settings import Places
from assets import phantom_path
from enhance import EnhanceParams
from renderer.gaussians import DynamicGaussians
from renderer.splat_files.inria_ply import ply_bytes
from tests.app.gui.test_opening import make_run
from tests.app.gui.test_session import opened_state, turn

Window = tuple[AppState, Channels]


@pytest.fixture
def clips(tmp_path: Path) -> tuple[Path, Path]:
    """Of two patients, in folders of one name."""
    one, other = (tmp_path / patient / "images" for patient in ("patient 1", "patient 2"))
    return Path(shutil.copytree(phantom_path(), one)), Path(shutil.copytree(phantom_path(), other))


@pytest.fixture
def first(places: Places, clips: tuple[Path, Path]) -> Window:
    return opened_state(places, clips[0])


def settle(window: Window) -> None:
    for _ in range(4):
        turn(*window)


def reopened(places: Places, path: Path) -> AppState:
    return opened_state(places, path)[0]


def saved(window: Window, path: Path) -> Path:
    """The session is in this file from now on."""
    session_actions.save_to(window[0], path)
    settle(window)
    return path


def test_a_run_of_another_clip_is_not_kept_as_what_is_open(
    places: Places, clips: tuple[Path, Path], model: DynamicGaussians
) -> None:
    run = make_run(places.runs / "of patient 1", clips[0], model).path
    window = opened_state(places, run)
    state = window[0]
    assert session_actions.snapshot(state, places.pictures).run == SessionSource.of(run, places.pictures)
    state.runs.reconstruction.status = "running"  # While it is trained, another clip is opened.
    actions.open_path(state, clips[1])
    settle(window)
    state.runs.reconstruction.status = "finished"
    clip_actions.trim_here(state, start=True)
    session = snapshot(state, places.pictures)
    assert (session.run, session.source) == (None, SessionSource.of(clips[1], places.pictures))
    write_session(places.pictures / "a.vesselsplat", session)
    clip = reopened(places, places.pictures / "a.vesselsplat").source.clip
    assert clip is not None
    assert clip.path == clips[1]


def test_what_the_next_run_is_to_be_comes_back_beside_a_run(
    places: Places, clips: tuple[Path, Path], model: DynamicGaussians
) -> None:
    state = reopened(places, make_run(places.runs / "run", clips[0], model).path)
    job_actions.choose_method(state, "vesselsplat", 6000)
    job_actions.choose_input(state, "original")
    write_session(places.pictures / "a.vesselsplat", snapshot(state, places.pictures))
    draft = reopened(places, places.pictures / "a.vesselsplat").runs.reconstruction
    assert (draft.config.iterations, draft.input) == (6000, "original")
    assert draft.request is not None
    assert draft.request.config.iterations == 40


def test_depth_that_is_still_read_is_kept_and_a_change_of_it_asked_about(
    first: Window, places: Places
) -> None:
    state, path = first[0], saved(first, places.pictures / "a.vesselsplat")
    assert not session_actions.look_for_changes(state)
    depth_actions.choose_source(state, "brightness")
    assert state.source.depth_wish is not None
    assert session_actions.look_for_changes(state)
    session_actions.save(state)
    turn(*first)
    turn(*first)
    assert mended_session(path)[0].clip_options.depth == "brightness"
    assert reopened(places, path).source.options.depth == "brightness"


def test_what_is_changed_while_another_clip_comes_is_asked_about(
    first: Window, places: Places, clips: tuple[Path, Path]
) -> None:
    state, path = first[0], saved(first, places.pictures / "a.vesselsplat")
    actions.open_path(state, clips[1])
    assert state.source.opening is not None
    notes_actions.write_notes(state, "polyp at 12 o'clock")
    settle(first)
    assert state.session.leaving is not None
    assert state.source.path == clips[0]
    session_actions.answer(state, "save")
    settle(first)
    assert state.source.path == clips[1]
    assert mended_session(path)[0].notes == "polyp at 12 o'clock"


def test_notes_and_summary_go_on_with_the_next_clip_and_a_new_case_begins_without(
    first: Window, clips: tuple[Path, Path], tmp_path: Path
) -> None:
    state = first[0]
    session_actions.ask_new_case(state)
    assert not state.session.asks_new_case
    notes_actions.write_notes(state, "bleeding")
    summary_actions.add_file(state, tmp_path / "saved.png")
    actions.open_path(state, clips[1])
    settle(first)
    assert state.window.toast is not None
    assert "New case" in state.window.toast.message
    session_actions.ask_new_case(state)
    session_actions.answer(state, "stay")
    assert state.session.notes == "bleeding"
    saved(first, tmp_path / "a.vesselsplat")
    session_actions.ask_new_case(state)
    assert state.session.asks_new_case  # Nothing is lost: it is in the file.
    session_actions.answer_new_case(state, agreed=True)
    assert (state.session.notes, state.summary.items, state.session.asks_new_case) == ("", (), False)


def test_a_new_case_leaves_the_file_of_the_one_before_as_it_is(first: Window, places: Places) -> None:
    state, path = first[0], places.pictures / "a.vesselsplat"
    notes_actions.write_notes(state, "polyp")
    saved(first, path)
    enhancement_actions.set_params(state, EnhanceParams(strength=0.5))
    session_actions.ask_new_case(state)
    session_actions.answer(state, "save")  # What has changed beside the case is asked about first.
    settle(first)
    assert (state.session.notes, state.session.path) == ("", None)
    notes_actions.write_notes(state, "of another person")
    session_actions.save(state)
    settle(first)
    asked = actions.taken_choice(state)
    assert asked is not None
    assert asked.purpose == "session"
    session, _ = mended_session(path)
    assert (session.notes, session.params) == ("polyp", EnhanceParams(strength=0.5))


def test_a_case_in_no_file_is_asked_about_before_it_ends(first: Window, places: Places) -> None:
    state, gone = first[0], list[str]()
    session_actions.leave_case(state, lambda: gone.append("nothing written down"))
    notes_actions.write_notes(state, "polyp")
    session_actions.leave_case(state, lambda: gone.append("saved"))
    session_actions.answer(state, "save")
    asked = actions.taken_choice(state)
    assert asked is not None
    assert gone == ["nothing written down"]
    browse_actions.chosen(state, asked, places.pictures / "a.vesselsplat")
    settle(first)
    assert gone == ["nothing written down", "saved"]
    assert mended_session(places.pictures / "a.vesselsplat")[0].notes == "polyp"
    session_actions.leave_case(state, lambda: gone.append("in the file"))
    summary_actions.type_title(state, "A case")
    session_actions.ask_new_case(state)
    session_actions.answer(state, "discard")
    assert gone[2:] == ["in the file"]
    assert not session_actions.has_case(state)


def test_a_given_up_file_dialog_saves_and_ends_nothing_later(first: Window, tmp_path: Path) -> None:
    state, gone = first[0], list[str]()
    notes_actions.write_notes(state, "polyp")
    session_actions.leave_case(state, lambda: gone.append("too late"))
    session_actions.answer(state, "save")
    assert actions.taken_choice(state) is not None
    saved(first, tmp_path / "later.vesselsplat")
    assert not gone


def test_the_notes_of_a_session_replace_others_only_after_a_question(first: Window, places: Places) -> None:
    state, path = first[0], places.pictures / "a.vesselsplat"
    write_session(path, snapshot(state, path.parent))
    notes_actions.write_notes(state, "polyp")
    actions.open_path(state, path)
    settle(first)
    assert (state.session.notes, state.session.path) == ("polyp", None)
    session_actions.answer(state, "discard")
    assert (state.session.notes, state.session.path) == ("", path)


def test_notes_that_were_given_up_with_a_clip_are_asked_about_in_the_next(
    first: Window, places: Places, clips: tuple[Path, Path]
) -> None:
    state = first[0]
    saved(first, places.pictures / "a.vesselsplat")
    notes_actions.write_notes(state, "polyp")
    session_actions.look_for_changes(state)
    actions.open_path(state, clips[1])
    session_actions.answer(state, "discard")
    settle(first)
    assert (state.source.path, state.session.notes) == (clips[1], "polyp")
    assert session_actions.loses_case(state)


def test_notes_without_a_source_are_saved_and_come_back(
    first: Window, places: Places, tmp_path: Path
) -> None:
    """As of a live source, of which nothing is a file."""
    state = first[0]
    state.source.path = None
    assert session_actions.autosave_request(state) is None
    assert not session_actions.has_content(state)
    notes_actions.write_notes(state, "seen live")
    (tmp_path / "saved.png").write_bytes(b"x")
    summary_actions.add_file(state, tmp_path / "saved.png")
    state.window.now += 10.0
    assert session_actions.autosave_request(state) is not None
    path = saved(first, places.pictures / "live.vesselsplat")
    notes_actions.write_notes(state, "seen live, twice")
    assert session_actions.look_for_changes(state)
    again = reopened(places, path)
    assert (again.session.notes, again.session.path, again.source.path) == ("seen live", path, None)
    assert again.summary.items == (Item(tmp_path / "saved.png"),)
    # Undo leads to no summary of a case before.
    assert [step.images for step in again.enhancement.past] == [again.summary.items]
    assert again.is_empty
    assert not session_actions.look_for_changes(again)


def test_a_changed_run_does_not_take_the_place_of_what_is_opened(
    places: Places, clips: tuple[Path, Path], model: DynamicGaussians
) -> None:
    run = make_run(places.runs / "run", clips[0], model).path
    window = opened_state(places, run)
    state = window[0]
    actions.open_path(state, clips[1])
    wanted = state.source.opening
    changing_runs.take_changed(state, ChangeRequest(run, None, for_good=True), None)
    assert state.source.opening is wanted
    views = clips[0] / "views.json"
    actions.open_path(state, views)
    assert state.source.opening is wanted
    assert state.window.banner is not None
    assert "views.json joins what is open" in state.window.banner.message


def test_splats_opened_during_training_are_shown_beside_and_the_clip_stays(
    first: Window, tmp_path: Path, model: DynamicGaussians, places: Places, clips: tuple[Path, Path]
) -> None:
    state = first[0]
    (tmp_path / "a.ply").write_bytes(ply_bytes(model.raw))
    state.runs.reconstruction.status = "running"
    actions.open_path(state, tmp_path / "a.ply")
    settle(first)
    assert state.source.path == clips[0]
    assert state.window.banner is not None
    assert "wait for the first preview" in state.window.banner.message
    run = make_run(places.runs / "run", clips[1], model).path
    state.scene.model = reopened(places, run).scene.model
    actions.open_path(state, tmp_path / "a.ply")
    settle(first)
    assert state.scene.second.model is not None
    assert state.scene.second.model.path == tmp_path / "a.ply"
    assert state.source.path == clips[0]


def test_a_case_summary_takes_no_more_than_a_session_keeps(first: Window, tmp_path: Path) -> None:
    state = first[0]
    summary_actions.type_notes(state, "x" * 200_000)
    for number in range(MOST_ITEMS + 1):
        summary_actions.add_file(state, tmp_path / f"{number}.png")
    summary_actions.type_note(state, 0, "y" * 200_000)
    kept = snapshot(state, tmp_path).summary
    assert len(kept.pictures) == MOST_ITEMS
    assert len(kept.notes) == len(kept.pictures[0].note) == 100_000
    assert state.window.banner is not None
    assert "200 images already" in state.window.banner.message


def test_a_model_of_another_patient_is_not_of_the_clip_of_that_name(
    places: Places, clips: tuple[Path, Path], model: DynamicGaussians
) -> None:
    window = opened_state(places, make_run(places.runs / "run", clips[0], model).path)
    state = window[0]
    assert state.has_frames
    assert not state.shows_other_clip
    state.runs.reconstruction.status = "running"
    actions.open_path(state, clips[1])
    settle(window)
    assert state.source.path == clips[1]
    assert state.shows_other_clip
    assert not state.has_frames
    assert state.run_measures_request is None
