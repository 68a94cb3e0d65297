from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest

from app.gui.dialogs import Dialogs, has_desktop_dialogs, listing


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
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(shutil, "which", lambda name: None)
    assert not has_desktop_dialogs()
    dialogs = Dialogs(lambda path: None, folder)
    dialogs.ask("folder")
    assert dialogs.browser is not None
    assert dialogs.browser.folder == folder
    monkeypatch.setattr(shutil, "which", lambda name: f"/usr/bin/{name}" if name == "kdialog" else None)
    assert has_desktop_dialogs()
