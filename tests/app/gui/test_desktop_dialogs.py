"""The file dialog of the desktop, where there is one."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest
from imgui_bundle import portable_file_dialogs as desktop

from app.gui.frame import dialogs
from app.gui.frame.dialogs import has_desktop_dialogs
from app.gui.state.choosing import QUESTIONS
from tests.app.gui.chooser import Chooser


def test_on_linux_a_missing_dialog_program_is_not_taken_for_a_cancel(
    monkeypatch: pytest.MonkeyPatch, chooser: Chooser, tmp_path: Path
) -> None:
    assert not has_desktop_dialogs()
    chooser.ask("folder", "folder", tmp_path)
    assert chooser.browsing.folder == tmp_path
    monkeypatch.setattr(shutil, "which", lambda name: f"/usr/bin/{name}" if name == "kdialog" else None)
    assert has_desktop_dialogs()


class FakeDesktop:
    """A dialog of the desktop that has been answered."""

    asked: list[tuple[object, ...]]

    def __init__(self, answer: str | list[str]) -> None:
        self.answer, self.asked = answer, []

    def __call__(self, *given: object) -> FakeDesktop:
        self.asked.append(given)
        return self

    def ready(self, timeout: int) -> bool:
        return True

    def result(self) -> str | list[str]:
        return self.answer


def test_the_desktop_s_dialog_is_asked_with_folder_and_kinds_and_remembered(
    chooser: Chooser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "case"
    folder.mkdir()
    monkeypatch.setattr(dialogs, "has_desktop_dialogs", lambda: True)
    opens, saves, nothing = (
        FakeDesktop([str(folder / "2.png")]),
        FakeDesktop(str(folder / "mine")),
        FakeDesktop(""),
    )
    monkeypatch.setattr(desktop, "open_file", opens)
    monkeypatch.setattr(desktop, "save_file", saves)
    monkeypatch.setattr(desktop, "select_folder", nothing)
    chooser.ask("file", "file", folder.parent)
    ((title, start, filters),) = opens.asked
    assert (title, start) == ("Open a file", str(folder.parent))
    assert filters[:2] == [
        "Everything that opens",
        " ".join(f"*{s}" for s in QUESTIONS["file"].filters[0].suffixes),
    ]
    assert chooser.state.folder_of("file") == folder
    chooser.ask("save", "session", folder, "liver.vesselsplat")
    assert saves.asked[0][1] == str(folder / "liver.vesselsplat")
    chooser.ask("folder", "folder", folder)
    assert chooser.chosen == [folder / "2.png", folder / "mine.vesselsplat"]


def test_macos_gets_a_name_alone_and_folders_that_are_there(
    chooser: Chooser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "platform", "darwin")
    folders, saves = FakeDesktop(""), FakeDesktop("")
    monkeypatch.setattr(desktop, "select_folder", folders)
    monkeypatch.setattr(desktop, "save_file", saves)
    chooser.ask("folder", "export", tmp_path / "none" / "VesselSplat")
    chooser.ask("save", "session", tmp_path, "liver.vesselsplat")
    assert folders.asked == [("Choose a folder for exports", str(tmp_path))]
    assert saves.asked[0][1] == "liver.vesselsplat"
