"""File names in another encoding than UTF-8: everything that shows a name shows them too."""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from app.enhancement.frame_enhancer import PictureMaker, PictureRequest
from app.exports.sheet import Panel, sheet
from app.files.legible import as_label, in_one_line, legible, located
from app.gui.actions import actions, browse_actions
from app.gui.commands import recent_commands
from app.gui.commands.commands import sections
from app.gui.frame.title import title_of
from app.gui.panels import menus, overlays
from app.gui.panels.file_browser import draw_browser
from app.gui.panels.palette import draw_palette
from app.gui.panels.reconstruction import draw_reconstruction
from app.gui.panels.welcome import draw_welcome
from app.gui.state.app_state import AppState
from app.gui.work.listing import ListRequest, list_folder
from app.gui.work.opening import OpenRequest
from app.gui.work.settings import Settings
from renderer.clip import Clip
from tests.app.gui.conftest import outside
from tests.app.gui.ui import Shown, Ui, compare

NAME = os.fsdecode(b"caf\xe9.png")

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="elsewhere file names are Unicode")


def test_what_utf_8_can_say_stays() -> None:
    assert legible("Gefäße 胃 é") == "Gefäße 胃 é"
    assert legible(NAME) == "caf?.png"


def test_accents_apart_from_their_letters_are_put_on_them() -> None:
    assert legible("Gefa\u0308\u00dfe") == "Gef\u00e4\u00dfe"
    assert as_label("a\u0308") == "\u00e4"


def test_names_with_line_breaks_take_one_line(state: AppState) -> None:
    assert in_one_line("new\nline\r\n 1.png") == "new line  1.png"
    assert as_label("a\nb") == "a b"
    state.source.path = Path("/clips/new\nline.png")
    assert title_of(state) == "new line.png - VesselSplat"


def test_labels_keep_their_hashes_and_the_mark_behind_them() -> None:
    for name in ("##", "a##b", "###", "a#b", "end#"):
        label = f"{as_label(name)}###id"
        assert label.index("##") == len(as_label(name))
        assert as_label(name).replace("\u200b", "") == name
    assert as_label(NAME) == "caf?.png"


def test_the_welcome_and_the_menu_show_such_names(ui: Ui, state: AppState) -> None:
    state.source.clip, state.settings = None, Settings(recent=(f"/clips/{NAME}",))
    ui.frame(lambda: draw_welcome(state, Shown()))
    ui.frame(lambda: menus.draw_commands(state, recent_commands.opening(state)))
    state.window.palette.open()
    state.window.palette.type("caf")
    for _ in range(2):
        ui.frame(lambda: draw_palette(state, sections(state, outside())))
    state.source.opening = OpenRequest(Path(NAME))
    ui.frame(lambda: draw_welcome(state, Shown()))


def test_the_panels_show_such_names(ui: Ui, state: AppState, clip: Clip) -> None:
    state.source.clip = replace(clip, name=NAME, labels=(NAME,) * len(clip))
    state.picture.pictures = list(PictureMaker().make(PictureRequest(state.source.clip, 0, None)))[-1]
    ui.frame(compare(state, Shown()))
    ui.frame(lambda: menus.draw_status(state))
    run = state.runs.reconstruction
    run.status, run.failure, run.warnings = "failed", f"no {NAME}", [NAME]
    ui.frame(lambda: draw_reconstruction(state))


def test_what_is_said_is_legible(ui: Ui, state: AppState) -> None:
    actions.fail(state, f"cannot read {NAME}")
    actions.announce(state, f"saved {NAME}")
    for draw in (overlays.draw_banner, overlays.draw_toast):
        ui.frame(lambda draw=draw: draw(state))
    ui.frame(lambda: overlays.draw_log(state, imgui.set_clipboard_text))
    assert list(state.window.log) == ["cannot read caf?.png", "saved caf?.png"]


def test_the_file_dialog_lists_such_names(ui: Ui, state: AppState, tmp_path: Path) -> None:
    folder = tmp_path / NAME
    folder.mkdir()
    (folder / NAME).write_text("")
    actions.choose_path(state, "file", lambda state, path: None)
    assert state.window.choosing is not None
    browse_actions.begin(state, replace(state.window.choosing, start=folder))
    assert state.window.browsing is not None
    browse_actions.take_listing(state, state.window.browsing.request, *list_folder(ListRequest(folder)))
    for _ in range(3):
        ui.frame(lambda: draw_browser(state, Shown()))
    assert state.window.browsing.folder == folder
    assert [entry.path.name for entry in state.window.browsing.entries] == [NAME]


def test_a_saved_picture_s_captions_too() -> None:
    small = np.zeros((80, 200, 3), np.uint8)
    np.testing.assert_array_equal(sheet([Panel(NAME, small)]), sheet([Panel("caf?.png", small)]))


def test_a_folder_is_told_from_the_home_folder_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    assert located(tmp_path / "Pictures" / "a") == "Pictures/a/"
    assert located(tmp_path) == "the home folder"
    assert located(tmp_path.parent) == str(tmp_path.parent)
