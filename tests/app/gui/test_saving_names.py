"""A file to be written: where what is typed says, and never over another one without a question."""

from __future__ import annotations

from pathlib import Path

import pytest
from imgui_bundle import imgui
from imgui_bundle import portable_file_dialogs as desktop

from app.gui.actions import browse_actions
from app.gui.frame import dialogs
from app.gui.state.browsing import Browsing
from app.gui.state.choosing import Choosing
from tests.app.gui.chooser import Chooser
from tests.app.gui.test_desktop_dialogs import FakeDesktop

K = imgui.Key


@pytest.fixture
def folders(tmp_path: Path) -> tuple[Path, Path]:
    """Where a dialog begins, and another one with a session in it."""
    here, stick = tmp_path / "here", tmp_path / "stick"
    here.mkdir()
    stick.mkdir()
    (stick / "taken.vesselsplat").write_text("of last week")
    return here, stick


@pytest.mark.parametrize("typed", ["monday", "monday.vesselsplat"])
def test_a_name_completed_after_the_desktop_s_question_is_asked_about_again(
    chooser: Chooser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, typed: str
) -> None:
    wanted = tmp_path / "monday.vesselsplat"
    wanted.write_text("patient A")
    monkeypatch.setattr(dialogs, "has_desktop_dialogs", lambda: True)
    monkeypatch.setattr(desktop, "save_file", FakeDesktop(str(tmp_path / typed)))
    chooser.ask("save", "session", tmp_path)
    if typed == wanted.name:  # The desktop has asked about this very name.
        assert chooser.chosen == [wanted]
        return
    assert chooser.chosen == []
    assert browse_actions.target(chooser.browsing) == wanted
    chooser.press(K.enter)
    assert chooser.chosen == []
    chooser.press(K.tab)  # To the button, which says Replace.
    chooser.press(K.space)
    assert chooser.chosen == [wanted]


def test_nothing_is_written_into_a_folder_that_is_not_listed_yet(
    chooser: Chooser, folders: tuple[Path, Path]
) -> None:
    _, stick = folders
    browsing = Browsing(Choosing("save", chooser.chosen.append, "session", stick), stick, name="taken")
    chooser.state.window.browsing = browsing
    browse_actions.opens(chooser.state, browsing)
    assert chooser.chosen == []
    assert browse_actions.why_not(browsing) == "Reading the folder…"
    chooser.frames(4)
    assert browse_actions.why_not(browsing) == ""
    browse_actions.opens(chooser.state, browsing)
    assert chooser.chosen == []
    assert browse_actions.replaces(browsing)


def test_a_path_that_is_typed_is_where_the_file_is_written(
    chooser: Chooser, folders: tuple[Path, Path]
) -> None:
    here, stick = folders

    def asked() -> Browsing:
        browse_actions.cancel(chooser.state)
        chooser.frames(2)
        chooser.ask("save", "session", here, "B.vesselsplat")
        return chooser.browsing

    browse_actions.type_path(asked(), str(stick / "patientB"))
    browse_actions.opens(chooser.state, chooser.browsing)
    assert chooser.chosen.pop() == stick / "patientB.vesselsplat"

    browse_actions.type_path(asked(), str(stick / "taken.vesselsplat"))
    browse_actions.opens(chooser.state, chooser.browsing)
    assert chooser.chosen == []
    assert browse_actions.replaces(chooser.browsing)
    browse_actions.type_name(chooser.browsing, "other")  # What is typed last counts.
    assert browse_actions.target(chooser.browsing) == here / "other.vesselsplat"

    browse_actions.type_path(asked(), str(stick))
    browse_actions.type_name(chooser.browsing, "other")
    browse_actions.choose(chooser.state, chooser.browsing)
    assert chooser.chosen.pop() == stick / "other.vesselsplat"

    browse_actions.type_path(asked(), str(stick / "gone" / "x"))
    assert browse_actions.why_not(chooser.browsing) == "There is no such folder."
