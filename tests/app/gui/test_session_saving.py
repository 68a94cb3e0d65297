"""Saving a session: by a name that is asked for once, among recent files, and what has changed since."""

from __future__ import annotations

import json
import shutil
from pathlib import Path, PureWindowsPath

import glfw
import pytest
from imgui_bundle import glfw_utils, imgui

from app.files.provenance import digest
from app.gui import session_file
from app.gui.actions import (
    actions,
    browse_actions,
    comparing,
    enhancement_actions,
    notes_actions,
    session_actions,
)
from app.gui.commands import recent_commands
from app.gui.commands.commands import sections
from app.gui.commands.keys import chord
from app.gui.frame import dockings
from app.gui.frame.title import title_of
from app.gui.session_file import SessionSource, mended_session
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.gui.work.runs import RunFinder, RunsRequest
from app.gui.work.settings import Places
from assets import phantom_path
from enhance import EnhanceParams
from renderer.gaussians import DynamicGaussians
from tests.app.gui.conftest import outside
from tests.app.gui.driver import Driver, is_settled, wait
from tests.app.gui.test_opening import make_run
from tests.app.gui.test_session import opened_state, turn


@pytest.fixture
def liver(places: Places, tmp_path: Path) -> tuple[AppState, Channels]:
    """A clip is open."""
    return opened_state(places, Path(shutil.copytree(phantom_path(), tmp_path / "clips" / "liver")))


def keys(state: AppState) -> dict[str, str]:
    """What each chord does now."""
    commands = [one for section in sections(state, outside()) for one in section.commands]
    return {keys: one.label for one in commands if one.applies(state) for keys in one.keys}


def test_no_image_waits_for_a_session_that_is_saved() -> None:
    """Saving reads all that is open, for its digests."""
    channels = Channels()
    assert {channels.sessions, channels.autosaves} <= set(channels.of("second"))


def test_nothing_that_is_saved_or_listed_waits_for_measuring() -> None:
    """Of a frame of 3840x2160 it takes more than 10 s, and of a clip what can be left out up to a minute."""
    channels = Channels()
    slow = {channels.measures, channels.omissions}
    assert slow == set(channels.of("third"))
    assert slow.isdisjoint({*channels.of("first"), *channels.of("second")})


def test_the_first_save_asks_and_the_next_ones_write_the_same_file(
    liver: tuple[AppState, Channels], places: Places
) -> None:
    state, channels = liver
    assert (keys(state)["Ctrl+S"], keys(state)["Ctrl+Shift+S"]) == ("Save session", "Save session as…")
    session_actions.save(state)
    asked = actions.taken_choice(state)
    assert asked is not None
    assert (asked.kind, asked.name, asked.start) == ("save", "liver.vesselsplat", places.pictures)
    assert state.session.path is None
    browse_actions.chosen(state, asked, places.pictures / "monday.vesselsplat")
    turn(state, channels)
    turn(state, channels)
    assert state.session.path == places.pictures / "monday.vesselsplat"
    state.session.notes = "a second look"
    session_actions.save(state)
    assert actions.taken_choice(state) is None
    turn(state, channels)
    turn(state, channels)
    assert [path.name for path in places.pictures.iterdir()] == ["monday.vesselsplat"]
    assert mended_session(state.session.path)[0].notes == "a second look"


def test_another_name_is_written_from_then_on(liver: tuple[AppState, Channels], places: Places) -> None:
    state, channels = liver
    session_actions.save_to(state, places.pictures / "monday.vesselsplat")
    turn(state, channels)
    turn(state, channels)
    session_actions.save_as(state)
    asked = actions.taken_choice(state)
    assert asked is not None
    assert asked.name == "monday.vesselsplat"
    state.session.notes = "tuesday"
    browse_actions.chosen(state, asked, places.pictures / "tuesday.vesselsplat")
    turn(state, channels)
    turn(state, channels)
    assert mended_session(places.pictures / "monday.vesselsplat")[0].notes == ""
    assert mended_session(places.pictures / "tuesday.vesselsplat")[0].notes == "tuesday"
    assert state.session.path == places.pictures / "tuesday.vesselsplat"


def test_a_saved_session_is_among_recent_files_and_opens_from_there(
    liver: tuple[AppState, Channels], places: Places
) -> None:
    state, channels = liver
    path = places.pictures / "monday.vesselsplat"
    session_actions.save_to(state, path)
    assert str(path) not in state.settings.recent  # It is not written yet.
    turn(state, channels)
    turn(state, channels)
    assert state.settings.recent[0] == str(path)
    enhancement_actions.set_params(state, EnhanceParams(z=0.5))
    first = recent_commands.opening(state)[0]
    assert first.label.startswith("monday.vesselsplat")
    first.act(state)
    for _ in range(4):
        turn(state, channels)
    assert state.session.leaving is not None  # The new setting is in no file.
    session_actions.answer(state, "discard")
    assert state.session.path == path
    assert state.enhancement.params != EnhanceParams(z=0.5)


def test_a_session_that_cannot_be_written_is_not_among_them(
    liver: tuple[AppState, Channels], places: Places
) -> None:
    state, channels = liver
    places.pictures.write_text("in the way")
    session_actions.save_to(state, places.pictures / "monday.vesselsplat")
    turn(state, channels)
    turn(state, channels)
    assert state.window.banner is not None
    assert "monday.vesselsplat" not in " ".join(state.settings.recent)


def test_what_has_changed_since_is_marked_and_looking_around_is_no_change(
    liver: tuple[AppState, Channels], places: Places
) -> None:
    state, channels = liver
    assert title_of(state) == "liver - VesselSplat"
    state.session.notes = "nothing to lose: no file"
    turn(state, channels)
    assert title_of(state) == "liver - VesselSplat"
    path = places.pictures / "monday.vesselsplat"
    session_actions.save_to(state, path)
    for _ in range(3):
        turn(state, channels)
    assert title_of(state) == "monday.vesselsplat - VesselSplat"
    actions.seek(state, 4)
    state.scene.kind = "depth"
    turn(state, channels)
    assert title_of(state) == "monday.vesselsplat - VesselSplat"
    comparing.store(state, "A")
    turn(state, channels)
    assert title_of(state) == "monday.vesselsplat* - VesselSplat"
    session_actions.save(state)
    turn(state, channels)
    turn(state, channels)
    assert title_of(state) == "monday.vesselsplat - VesselSplat"
    other, channels = opened_state(places, path)
    for _ in range(3):
        turn(other, channels)
    assert title_of(other) == "monday.vesselsplat - VesselSplat"
    enhancement_actions.set_params(other, EnhanceParams(z=0.5))
    turn(other, channels)
    assert title_of(other) == "monday.vesselsplat* - VesselSplat"
    actions.open_path(other, phantom_path())
    turn(other, channels)
    assert title_of(other) == "monday.vesselsplat* - VesselSplat"  # A question comes first.
    session_actions.answer(other, "discard")
    for _ in range(4):
        turn(other, channels)
    assert title_of(other) == "phantom - VesselSplat"
    assert title_of(AppState(places)) == "VesselSplat"


@pytest.mark.display
def test_from_the_key_to_the_file(places: Places, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.gui.frame.dialogs.has_desktop_dialogs", lambda: False)
    driver = Driver(places, opens=phantom_path())
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        ctx.key_press(chord("Ctrl+S"))
        wait(ctx, lambda: state.window.browsing is not None, "the dialog")
        ctx.yield_(4)
        ctx.key_chars("monday")
        ctx.yield_(2)
        ctx.key_press(imgui.Key.enter)
        wait(ctx, lambda: (places.pictures / "monday.vesselsplat").is_file(), "the session")
        before = (places.pictures / "monday.vesselsplat").stat().st_mtime_ns
        ctx.yield_(4)
        ctx.key_press(chord("Ctrl+S"))
        wait(
            ctx,
            lambda: (places.pictures / "monday.vesselsplat").stat().st_mtime_ns > before,
            "the session once more",
        )
        assert state.window.browsing is None
        ctx.key_press(chord("Ctrl+Shift+S"))
        wait(ctx, lambda: state.window.browsing is not None, "the dialog")
        ctx.yield_(4)
        ctx.key_press(imgui.Key.escape)
        wait(ctx, lambda: state.window.browsing is None, "its end")

    driver.run(drive)
    assert [path.name for path in places.pictures.iterdir()] == ["monday.vesselsplat"]
    assert state.settings.recent[0] == str(places.pictures / "monday.vesselsplat")


@pytest.mark.display
def test_changes_of_a_saved_session_are_not_lost_without_a_question(places: Places) -> None:
    driver = Driver(places, opens=phantom_path())
    state, path = driver.state, places.pictures / "monday.vesselsplat"

    def close(ctx: imgui.test_engine.TestContext) -> None:
        glfw.set_window_should_close(glfw_utils.glfw_window_hello_imgui(), 1)
        wait(ctx, lambda: state.session.leaving is not None, "the question")
        ctx.yield_(3)

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        session_actions.save_to(state, path)
        wait(ctx, lambda: path.is_file() and not state.session.is_unsaved, "the session")
        ctx.item_input_value("//Enhancement/**/##strength", 0.5)
        close(ctx)  # At once: before it is saved in passing, which tells of changes.
        ctx.item_click("//Unsaved changes/Stay")
        ctx.yield_(3)
        assert state.session.is_unsaved
        actions.open_path(state, phantom_path())
        ctx.yield_(3)
        assert state.source.opening is None
        ctx.key_press(imgui.Key.escape)
        ctx.yield_(3)
        assert state.session.leaving is None
        actions.open_path(state, path)
        ctx.yield_(3)
        ctx.item_click("//Unsaved changes/Save")
        wait(ctx, lambda: state.session.after_saving is None, "the changes in the file")
        wait(ctx, lambda: state.source.opening is None and is_settled(state), "the session, once more")
        assert state.enhancement.params.strength == 0.5
        ctx.item_input_value("//Enhancement/**/##strength", 1.5)
        wait(ctx, lambda: state.session.is_unsaved, "the mark")
        actions.open_path(state, phantom_path())
        ctx.yield_(3)
        ctx.item_click("//Unsaved changes/Discard")
        wait(ctx, lambda: state.session.path is None, "the phantom, without the session")

    driver.run(drive)
    assert mended_session(path)[0].params.strength == 0.5


def test_a_person_says_where_a_lost_clip_lies_now(
    liver: tuple[AppState, Channels], places: Places, tmp_path: Path
) -> None:
    state, channels = liver
    state.session.notes = "a second look"
    session_actions.save_to(state, places.pictures / "monday.vesselsplat")
    turn(state, channels)
    turn(state, channels)
    moved = shutil.move(tmp_path / "clips" / "liver", tmp_path / "archive")
    other, channels = opened_state(places, places.pictures / "monday.vesselsplat")
    banner = other.window.banner
    assert banner is not None
    assert "neither" in banner.message
    assert banner.find is not None
    banner.find()
    asked = actions.taken_choice(other)
    assert asked is not None
    assert asked.kind == "folder"
    browse_actions.chosen(other, asked, Path(moved))
    turn(other, channels)
    turn(other, channels)
    assert (other.window.banner, other.source.path) == (None, Path(moved))
    assert (other.session.path, other.session.notes) == (
        places.pictures / "monday.vesselsplat",
        "a second look",
    )
    session_actions.save(other)
    turn(other, channels)
    turn(other, channels)
    again, _ = opened_state(places, places.pictures / "monday.vesselsplat")
    assert (again.window.banner, again.source.path) == (None, Path(moved))


def test_saving_in_passing_puts_off_no_save_that_was_asked_for(
    liver: tuple[AppState, Channels], places: Places
) -> None:
    """While the worker is busy with something long."""
    state, channels = liver
    session_actions.save_to(state, places.pictures / "monday.vesselsplat")
    for frame in range(1, 8):
        actions.seek(state, frame)
        update(state, channels, state.window.now + 2 * session_actions.AUTOSAVE_SECONDS)
    turn(state, channels)
    turn(state, channels)
    assert (places.pictures / "monday.vesselsplat").is_file()
    assert state.window.toast is not None
    assert "saved monday.vesselsplat" in state.window.toast.message


def test_a_run_whose_clip_was_moved_is_shown_with_it_where_a_person_says(
    places: Places, tmp_path: Path, model: DynamicGaussians
) -> None:
    clip = Path(shutil.copytree(phantom_path(), tmp_path / "clips" / "liver"))
    run = make_run(places.runs / "first", clip, model)
    facts = json.loads(run.record_path.read_text())
    facts["clip"] |= {"sha256": digest(clip), "files": "read"}
    run.record_path.write_text(json.dumps(facts))
    moved = clip.rename(clip.with_name("renamed"))
    state, channels = opened_state(places, run.path)
    banner = state.window.banner
    assert state.source.clip is None
    assert state.scene.model is not None
    assert banner is not None
    assert banner.find is not None
    banner.find()
    asked = actions.taken_choice(state)
    assert asked is not None
    browse_actions.chosen(state, asked, Path(phantom_path()).parent)
    turn(state, channels)
    turn(state, channels)
    assert state.window.banner is not None
    assert "got another" in state.window.banner.message
    browse_actions.chosen(state, asked, moved)
    turn(state, channels)
    turn(state, channels)
    assert state.window.banner is None
    assert state.source.clip is not None
    assert state.source.clip.path == moved
    request = state.runs.reconstruction.request
    assert request is not None
    assert request.clip_path == moved
    assert state.scene.model.is_of(state.source.clip)
    (found,) = RunFinder().find(RunsRequest(places.runs, state.source.clip, 0))
    assert [one.path for one in found.runs] == [run.path]
    other, channels = opened_state(places, moved)
    actions.open_path(other, run.path)
    turn(other, channels)
    turn(other, channels)
    assert other.window.banner is None
    assert other.scene.model is not None
    assert other.source.clip is not None
    assert (other.source.clip.path, other.scene.model.is_of(other.source.clip)) == (moved, True)


@pytest.mark.display
def test_a_case_in_no_file_keeps_the_window_open_until_it_is_answered(places: Places) -> None:
    driver = Driver(places, opens=phantom_path())
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        notes_actions.write_notes(state, "left ureter?")
        glfw.set_window_should_close(glfw_utils.glfw_window_hello_imgui(), 1)
        wait(ctx, lambda: state.session.leaving is not None, "the question")
        ctx.yield_(3)
        ctx.item_click("//Unsaved case/Stay")
        ctx.yield_(3)
        assert (state.session.leaving, state.session.notes) == (None, "left ureter?")
        session_actions.save_to(state, path := places.pictures / "monday.vesselsplat")
        wait(ctx, lambda: not session_actions.loses_case(state), "the session")
        assert not dockings.is_shown("Notes")
        actions.open_path(state, path)
        wait(ctx, lambda: state.source.opening is None and dockings.is_shown("Notes"), "its notes")
        wait(ctx, lambda: not state.source.asked and not state.session.notes_asked, "all panels")

    driver.run(drive)
    assert mended_session(places.pictures / "monday.vesselsplat")[0].notes == "left ureter?"


class WindowsFolder(PureWindowsPath):
    """With the drive of the sessions alone."""

    def absolute(self) -> WindowsFolder:
        return self

    def exists(self) -> bool:
        return str(self).lower().startswith("c:\\cases")


def test_a_drive_that_was_taken_out_is_not_found_where_the_session_lies(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(session_file, "Path", WindowsFolder)
    session = WindowsFolder("C:/cases/jane.vesselsplat")
    found = {name: SessionSource(name).found(session) for name in ("D:/", "D:/clip")}  # type: ignore[arg-type]
    assert found == {"D:/": None, "D:/clip": WindowsFolder("C:/cases/clip")}
