"""The window's own file dialog, by keyboard and by mouse."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

import pytest
from imgui_bundle import imgui

from app.gui.actions import actions, browse_actions
from app.gui.panels import file_browser
from app.gui.state.app_state import AppState
from app.gui.state.browsing import Browsing
from app.gui.state.choosing import QUESTIONS, Choosing, Kind, Purpose
from app.gui.style.widgets import button
from app.gui.work.listing import Entry, Listing, entry_at
from app.gui.work.settings import Places, load_settings
from tests.app.gui.chooser import Chooser
from tests.app.gui.settling import keep_all

K = imgui.Key


def test_folders_come_first_in_natural_order_and_hidden_things_never(chooser: Chooser, case: Path) -> None:
    chooser.ask("file", "file", case)
    assert chooser.names() == ["A clip", "b clip", "2.png", "10.png", "notes.txt", "scope.mp4"]
    browse_actions.choose_filter(chooser.browsing, 2)
    assert QUESTIONS["file"].filters[2].label == "Videos"
    assert chooser.names() == ["A clip", "b clip", "scope.mp4"]
    browse_actions.cancel(chooser.state)
    chooser.ask("folder", "folder", case)
    assert chooser.names() == ["A clip", "b clip"]


def test_the_list_is_sorted_by_date_and_size(chooser: Chooser, case: Path) -> None:
    (case / "10.png").write_bytes(b"12345")
    for age, name in enumerate(("2.png", "scope.mp4", "10.png", "notes.txt")):
        os.utime(case / name, (time.time() - 1000 * age,) * 2)
    chooser.ask("file", "file", case)
    browse_actions.sort(chooser.browsing, "date", descending=True)
    assert chooser.names()[2:] == ["2.png", "scope.mp4", "10.png", "notes.txt"]
    browse_actions.sort(chooser.browsing, "size", descending=True)
    assert chooser.names()[:3] == ["b clip", "A clip", "10.png"]


def test_enter_opens_what_is_typed_but_not_what_the_dialog_begins_with(chooser: Chooser, case: Path) -> None:
    state = chooser.state
    state.window.folders = {"folder": case}
    chooser.ui.io.add_key_event(K.enter, True)
    actions.choose_path(state, "folder", lambda state, path: chooser.chosen.append(path))
    chooser.frames(1)
    chooser.ui.io.add_key_event(K.enter, False)
    chooser.frames(3)
    assert chooser.chosen == []
    browse_actions.cancel(state)
    chooser.frames(2)
    chooser.ask("file", "file", case)
    chooser.type("2.png")
    assert chooser.chosen == []
    chooser.press(K.enter)
    assert chooser.chosen == [case / "2.png"]
    assert state.window.browsing is None


def test_a_folder_whose_path_is_typed_to_its_end_is_listed(chooser: Chooser, case: Path) -> None:
    (case / "A clip" / "1.png").touch()
    chooser.ask("file", "file", case / "b clip")
    chooser.type(f"{case}/A clip/")
    assert chooser.browsing.folder == case / "A clip"
    assert "1.png" in chooser.names()
    assert chooser.browsing.text == f"{case}/A clip/"
    # From the folder on: it stays the one that this begins with.
    browse_actions.type_path(chooser.browsing, "../b clip/")
    assert chooser.browsing.folder == case / "A clip"
    assert browse_actions.typed_path(chooser.browsing).resolve() == (case / "b clip").resolve()


def test_the_beginning_of_a_name_narrows_the_list_and_the_only_one_left_opens(
    chooser: Chooser, case: Path
) -> None:
    chooser.ask("file", "file", case)
    everything = chooser.names()
    (case / "10.png.bak").write_text("")  # Not listed: it does not open.
    for text, names in (
        ("1", ["10.png"]), ("S", ["scope.mp4"]), (str(case / "no"), ["notes.txt"]), ("zz", everything),
        (str(case), everything), (str(case) + os.sep, everything), ("", everything), ("a", ["A clip"]),
    ):  # fmt: skip
        browse_actions.type_path(chooser.browsing, text)
        assert chooser.names() == names, text
    for text, path in (("10.png.bak", "10.png.bak"), ("zz", "zz"), ("sc", "scope.mp4")):
        browse_actions.type_path(chooser.browsing, text)
        assert browse_actions.typed_path(chooser.browsing) == case / path
    assert not browse_actions.why_not(chooser.browsing)


def test_a_listing_in_the_place_in_memory_of_one_that_is_gone_is_listed_anew(
    chooser: Chooser, case: Path
) -> None:
    """Python gives the room of what is freed to what comes next: one and the same id for both."""
    browsing = Browsing(Choosing("file", chooser.chosen.append, "file", case), case)
    found = {inside: (Entry(inside / "x.png", "file"),) for inside in (case, case / "A clip")}
    for inside in (*found, *found):
        browsing.listing = None
        browsing.listing = Listing(inside, found[inside])
        assert browsing.entries == found[inside]


def test_a_file_that_is_not_there_is_said_not_to_be(
    chooser: Chooser, case: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    texts: list[str] = []
    monkeypatch.setattr(file_browser, "muted", texts.append)
    chooser.ask("file", "file", case)
    assert texts[-1] == "Open folder (Ctrl+O) opens a whole folder."
    chooser.press(K.down_arrow)
    assert texts[-1].startswith("Enter opens")
    chooser.type("gone.png")
    chooser.press(K.enter)
    assert texts[-1] == "There is no such file."
    assert chooser.chosen == []


def test_with_large_text_what_is_said_below_the_list_is_within_the_dialog(
    chooser: Chooser, case: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    texts: list[str] = []
    monkeypatch.setattr(file_browser, "muted", texts.append)
    chooser.ask("file", "file", case)
    assert texts[-1] == file_browser.WHOLE_FOLDER
    imgui.get_style().font_scale_main = 2.0
    chooser.frames(2)
    first, last = texts[-1].split("…")
    assert file_browser.WHOLE_FOLDER.startswith(first)
    assert file_browser.WHOLE_FOLDER.endswith(last)


@pytest.mark.parametrize("kind", ["file", "folder"])
def test_of_a_folder_that_is_still_read_nothing_is_said_not_to_be_there(
    state: AppState, case: Path, kind: Kind
) -> None:
    browsing = Browsing(Choosing(kind, [].append, kind, case), case)
    browse_actions.type_path(browsing, str(case / "sco"))
    assert browse_actions.why_not(browsing) == "Reading the folder…"
    browsing.listing = Listing(case, ())
    assert browse_actions.why_not(browsing) == f"There is no such {kind}."


def test_folders_are_told_from_files(
    chooser: Chooser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    monkeypatch.setattr(file_browser, "muted", said.append)
    (tmp_path / "a.png").write_bytes(b"0" * 4000)
    (tmp_path / "b").mkdir()
    chooser.ask("file", "file", tmp_path)
    case, file = said[-5:-3], said[-3:-1]  # The folder's row comes first, the hint last.
    assert (case[1], file[1]) == ("folder", "4 kB")


def test_where_a_folder_is_asked_for_videos_that_are_not_listed_are_told_of(
    chooser: Chooser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    monkeypatch.setattr(file_browser, "muted", said.append)
    for name in ("a.mp4", "B.AVI", "c.png", "d.txt"):
        (tmp_path / name).write_text("")
    (tmp_path / "empty.mp4").mkdir()
    chooser.ask("folder", "folder", tmp_path)
    assert said[-1] == "Open file (Ctrl+I) lists the 2 videos here."
    chooser.press(K.escape)
    (tmp_path / "a.mp4").unlink()
    chooser.ask("folder", "folder", tmp_path)
    assert said[-1] == "Open file (Ctrl+I) lists the video here."
    chooser.press(K.escape)
    chooser.ask("folder", "masks", tmp_path)
    assert said[-1].startswith("Enter goes in")


def test_a_dialog_says_what_is_done_with_what_is_chosen(
    chooser: Chooser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said, labels = list[str](), list[str]()

    def noted(label: str, *given: Any, **more: Any) -> bool:
        labels.append(label)
        return button(label, *given, **more)

    monkeypatch.setattr(file_browser, "button", noted)
    for name in ("centered", "muted"):
        monkeypatch.setattr(file_browser, name, lambda text, *color: said.append(text))
    (tmp_path / "a.png").write_text("")
    asked: tuple[tuple[Purpose, str, str], ...] = (
        ("folder", "Open", "No subfolder. Open uses this folder and the files in it."),
        ("export", "Choose", "No subfolder. Choose uses this folder."),
        ("inputs", "Add", "No subfolder. Add uses this folder and the files in it."),
    )
    for purpose, verb, empty in asked:
        chooser.ask("folder", purpose, tmp_path)
        assert f"{verb}###choose" in labels
        assert empty in said
        assert f"Enter goes in; Enter again {verb.lower()}s the folder." in said
        chooser.press(K.escape)


def test_arrows_mark_and_enter_goes_in_or_opens(chooser: Chooser, case: Path) -> None:
    (case / "b clip" / "x.png").write_text("")
    chooser.ask("file", "file", case)
    chooser.press(K.down_arrow)
    chooser.press(K.down_arrow)
    assert chooser.browsing.marked == case / "b clip"
    chooser.press(K.enter)
    assert chooser.browsing.folder == case / "b clip"
    assert chooser.browsing.marked is None
    chooser.press(K.enter)  # The folder itself is no file.
    assert chooser.chosen == []
    chooser.press(K.up_arrow)
    assert chooser.browsing.marked == case / "b clip" / "x.png"
    chooser.press(K.enter)
    assert chooser.chosen == [case / "b clip" / "x.png"]


def test_backspace_and_alt_up_go_to_the_folder_above_and_mark_where_one_was(
    chooser: Chooser, case: Path
) -> None:
    chooser.ask("file", "file", case / "b clip")
    chooser.press(K.backspace)
    assert (chooser.browsing.folder, chooser.browsing.marked) == (case, case / "b clip")
    chooser.press(K.left_alt, K.mod_alt, K.up_arrow)
    assert (chooser.browsing.folder, chooser.browsing.marked) == (case.parent, case)
    # In what is typed it deletes a letter.
    chooser.type("case/2.pngx")
    chooser.press(K.backspace)
    assert chooser.browsing.folder == case.parent
    chooser.press(K.enter)
    assert chooser.chosen == [case / "2.png"]


def test_a_folder_is_gone_into_and_then_chosen(chooser: Chooser, case: Path) -> None:
    chooser.ask("folder", "folder", case)
    chooser.type("A clip")
    chooser.press(K.enter)
    assert (chooser.browsing.folder, chooser.chosen) == (case / "A clip", [])
    chooser.press(K.enter)
    assert chooser.chosen == [case / "A clip"]


def test_a_file_whose_path_is_typed_opens_where_a_folder_is_asked_for(
    chooser: Chooser, case: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    chooser.ask("folder", "folder", case)
    chooser.type("2.png")
    chooser.press(K.enter)
    assert chooser.chosen == [case / "2.png"]
    texts: list[str] = []
    monkeypatch.setattr(file_browser, "muted", texts.append)
    chooser.ask("folder", "results", case)
    chooser.type("2.png")
    chooser.press(K.enter)
    assert texts[-1] == "Choose a folder."
    assert len(chooser.chosen) == 1


def test_a_click_marks_and_a_double_click_opens(chooser: Chooser, case: Path) -> None:
    chooser.ask("file", "file", case)
    io, place = chooser.ui.io, 2
    table = next(
        window
        for window in imgui.get_current_context().windows
        if "files" in window.name and window.active and window.parent_window is not None
    )
    row = 2.6 * imgui.get_style().font_size_base
    y = table.inner_rect.min.y + 1.4 * imgui.get_style().font_size_base + (place + 0.7) * row
    io.add_mouse_pos_event(table.pos.x + 120, y)
    chooser.frames(2)

    def click() -> None:
        for down in (True, False):
            io.add_mouse_button_event(0, down)
            chooser.frames(1)

    click()
    assert chooser.browsing.marked == case / "2.png"
    click()
    assert chooser.chosen == [case / "2.png"]


def test_escape_cancels_and_no_control_below_is_in_focus(chooser: Chooser, case: Path) -> None:
    chooser.ask("file", "file", case)
    chooser.press(K.down_arrow)
    chooser.press(K.escape)
    assert (chooser.state.window.browsing, chooser.chosen) == (None, [])
    chooser.ask("file", "file", case)
    chooser.type("2.png")
    chooser.press(K.enter)
    assert chooser.chosen == [case / "2.png"]
    assert not chooser.ui.io.nav_visible


def test_each_purpose_begins_where_it_was_also_after_a_restart(
    chooser: Chooser, case: Path, places: Places
) -> None:
    chooser.ask("file", "file", case)
    chooser.type("2.png")
    chooser.press(K.enter)
    chooser.ask("folder", "export", case.parent)
    chooser.type("case/A clip")
    chooser.press(K.enter)
    chooser.press(K.enter)
    assert chooser.chosen[1] == case / "A clip"
    assert chooser.state.export_folder == case / "A clip"
    keep_all(chooser.state)
    again = AppState(places, load_settings(places.settings_file))
    assert (again.folder_of("file"), again.export_folder) == (case, case / "A clip")
    actions.choose_path(again, "file", lambda state, path: None)
    assert again.window.choosing is not None
    assert again.window.choosing.start == case
    assert again.folder_of("run") is None


def test_the_disk_is_asked_once_for_what_is_typed_and_never_for_what_is_listed(
    chooser: Chooser, case: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A folder on a network may take long to answer, and a window that asks in each frame stands still."""
    asked: list[Path] = []
    monkeypatch.setattr(browse_actions, "entry_at", lambda path: asked.append(path) or entry_at(path))
    chooser.ask("file", "file", case)
    browse_actions.mark(chooser.browsing, chooser.browsing.entries[-1])
    chooser.frames(5)
    assert not asked
    chooser.type("nowhere/a.png")
    chooser.frames(5)
    assert asked == [case / "nowhere" / "a.png"]
    assert browse_actions.why_not(chooser.browsing) == "There is no such file."


def test_a_folder_that_is_gone_gives_way_to_the_nearest_above(chooser: Chooser, case: Path) -> None:
    chooser.ask("file", "file", case / "gone" / "deeper")
    assert chooser.browsing.folder == case
    assert chooser.browsing.text == str(case)


def test_the_folder_of_a_file_to_be_written_need_not_be_there(chooser: Chooser, case: Path) -> None:
    chooser.ask("save", "session", case / "new", "liver.vesselsplat")
    assert chooser.names() == []
    chooser.press(K.enter)
    assert chooser.chosen == [case / "new" / "liver.vesselsplat"]


def test_a_name_is_asked_for_and_a_file_is_replaced_only_when_that_is_said(
    chooser: Chooser, case: Path
) -> None:
    (case / "old.vesselsplat").write_text("")
    chooser.ask("save", "session", case, "liver.vesselsplat")
    assert chooser.names() == ["A clip", "b clip", "old.vesselsplat"]
    chooser.press(K.enter)
    assert chooser.chosen == [case / "liver.vesselsplat"]
    chooser.ask("save", "session", case, "liver.vesselsplat")
    chooser.type("old")
    assert browse_actions.target(chooser.browsing) == case / "old.vesselsplat"
    chooser.press(K.enter)
    assert len(chooser.chosen) == 1
    chooser.press(K.tab)  # To the button, which says Replace.
    chooser.press(K.space)
    assert chooser.chosen[1] == case / "old.vesselsplat"
    chooser.ask("save", "session", case, "a/b")
    assert "/" in browse_actions.why_not(chooser.browsing)
    browse_actions.type_name(chooser.browsing, " ")
    assert "name" in browse_actions.why_not(chooser.browsing)


@pytest.mark.parametrize("text", ["~nobody-of-this-name", "x" * 300, "/" + "y" * 5000, "", "a\0b"])
def test_nothing_that_can_be_typed_breaks_the_dialog(chooser: Chooser, case: Path, text: str) -> None:
    chooser.ask("file", "file", case)
    browse_actions.type_path(chooser.browsing, text)
    browse_actions.opens(chooser.state, chooser.browsing)
    chooser.frames(2)
    assert chooser.chosen == []
    assert chooser.browsing.folder == case
