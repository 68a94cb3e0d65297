from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import pytest
from imgui_bundle import imgui

from app.gui.frame.dialogs import Dialogs, has_desktop_dialogs, kind_of, listing
from tests.app.gui.ui import Ui


@pytest.fixture(autouse=True)
def no_desktop(monkeypatch: pytest.MonkeyPatch) -> None:
    """No program that asks in the window's place."""
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(shutil, "which", lambda name: None)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("b clip", "A clip", ".hidden"):
        (tmp_path / name).mkdir()
    for name in ("2.png", "1.png", ".DS_Store"):
        (tmp_path / name).write_text("")
    return tmp_path


def test_folders_come_first_and_hidden_things_never(folder: Path) -> None:
    assert [entry.name for entry in listing(folder, "file")] == ["A clip", "b clip", "1.png", "2.png"]
    assert [entry.name for entry in listing(folder, "folder")] == ["A clip", "b clip"]


def test_a_folder_that_cannot_be_listed_is_empty(tmp_path: Path) -> None:
    assert listing(tmp_path / "nothing", "file") == []


def test_on_linux_a_missing_dialog_program_is_not_taken_for_a_cancel(
    monkeypatch: pytest.MonkeyPatch, folder: Path
) -> None:
    assert not has_desktop_dialogs()
    dialogs = Dialogs(folder)
    dialogs.ask("folder", lambda path: None)
    assert dialogs.browser is not None
    assert dialogs.browser.folder == folder
    monkeypatch.setattr(shutil, "which", lambda name: f"/usr/bin/{name}" if name == "kdialog" else None)
    assert has_desktop_dialogs()


@pytest.fixture
def plain(folder: Path) -> Dialogs:
    """The dialog inside the window, open in `folder`."""
    dialogs = Dialogs(folder)
    dialogs.ask("file", lambda path: None)
    return dialogs


def test_enter_opens_what_is_typed_but_not_what_the_dialog_begins_with(folder: Path, ui: Ui) -> None:
    chosen: list[Path] = []
    dialogs = Dialogs(folder)
    dialogs.ask("folder", chosen.append)
    ui.press(dialogs.draw, imgui.Key.enter)
    assert chosen == []
    dialogs.browser = None
    dialogs.ask("file", chosen.append)
    ui.frame(dialogs.draw)
    ui.frame(dialogs.draw)
    ui.io.add_input_characters_utf8("1.png")
    ui.frame(dialogs.draw)
    assert chosen == []
    ui.press(dialogs.draw, imgui.Key.enter)
    assert chosen == [folder / "1.png"]
    assert dialogs.browser is None


def test_after_enter_no_control_below_is_in_focus(folder: Path, ui: Ui) -> None:
    ui.io.config_flags |= imgui.ConfigFlags_.nav_enable_keyboard
    dialogs = Dialogs(folder)

    def draw() -> None:
        imgui.button("below")
        dialogs.draw()

    ui.frame(draw)
    dialogs.ask("file", lambda path: None)
    ui.frame(draw)
    ui.frame(draw)
    ui.io.add_input_characters_utf8("1.png")
    ui.frame(draw)
    ui.press(draw, imgui.Key.enter)
    for _ in range(3):
        ui.frame(draw)
    assert dialogs.browser is None
    assert not ui.io.nav_visible


@pytest.mark.parametrize("text", ["~nobody-of-this-name", "x" * 300, "/" + "y" * 5000, "", "a\0b"])
def test_nothing_that_can_be_typed_breaks_the_dialog(plain: Dialogs, folder: Path, text: str) -> None:
    assert plain.browser is not None
    plain.browser.type(text)
    assert kind_of(plain.browser.path) in (None, "folder")
    assert plain.browser.folder == folder
    plain.browser.type("A clip")
    assert plain.browser.folder == folder / "A clip"
    assert plain.browser.path == folder / "A clip"


def test_entries_that_may_not_be_looked_at_are_listed_and_cannot_be_chosen(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    look = Path.stat

    def stat(path: Path, **how: bool) -> os.stat_result:
        if path.name == "A clip":
            raise PermissionError(13, "Permission denied", str(path))
        return look(path, **how)

    monkeypatch.setattr(Path, "stat", stat)
    entries = {entry.name: entry.kind for entry in listing(folder, "file")}
    assert entries == {"b clip": "folder", "1.png": "file", "2.png": "file", "A clip": None}
    assert "A clip" not in [entry.name for entry in listing(folder, "folder")]


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere file names are Unicode")
def test_a_name_that_is_not_utf_8_is_shown_and_still_opens_its_file(folder: Path, plain: Dialogs) -> None:
    path = Path(os.fsdecode(os.fsencode(folder) + b"/caf\xe9.png"))
    path.write_text("")
    entry = listing(folder, "file")[-1]
    assert (entry.name, entry.path) == ("caf?.png", path)
    assert plain.browser is not None
    plain.browser.mark(entry.path)
    assert plain.browser.text.encode().endswith(b"caf?.png")
    assert kind_of(plain.browser.path) == "file"
