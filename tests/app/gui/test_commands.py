"""One list of commands: menus, keys, help and palette show all of it, and none of them lies."""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import replace
from itertools import groupby
from pathlib import Path

import pytest
from imgui_bundle import imgui

from app.gui.actions import job_actions
from app.gui.commands.command import Command, Section
from app.gui.commands.commands import sections
from app.gui.commands.finding import find
from app.gui.commands.keys import Keyboard, chord
from app.gui.commands.recent_commands import opening
from app.gui.panels import menus
from app.gui.panels.editing import HOW_TEXT
from app.gui.panels.palette import draw_palette
from app.gui.state.app_state import AppState
from app.gui.views.key_words import with_keys
from app.gui.views.recent_names import told_apart
from app.gui.work.settings import Places, Settings
from renderer.gaussians import DynamicGaussians
from tests.app.gui.conftest import outside, start_live
from tests.app.gui.ui import Draw, Ui


@pytest.fixture
def empty(places: Places) -> AppState:
    """Nothing open."""
    return AppState(places, Settings(acknowledged=True, recent=("/clips/a", "/other/a")))


@pytest.fixture
def editing(state: AppState, model: DynamicGaussians) -> AppState:
    start_live(state, model)
    state.editing.base, state.editing.active = state.scene.model, True
    return state


def commands(state: AppState) -> list[Command]:
    return [command for section in sections(state, outside()) for command in section.commands]


def palette(state: AppState) -> Draw:
    """A frame of the palette and the keyboard behind it."""
    keys = Keyboard()

    def draw() -> None:
        every = sections(state, outside())
        draw_palette(state, every)
        keys.handle(state, every)

    return draw


def test_every_menu_entry_is_in_the_palette(ui: Ui, empty: AppState, monkeypatch: pytest.MonkeyPatch) -> None:
    """With all menus unfolded, what is drawn is what the palette lists."""
    drawn: list[str] = []
    monkeypatch.setattr(imgui, "menu_item_simple", lambda label, *rest: drawn.append(label))
    every = sections(empty, outside())
    for _, grouped in groupby(every, lambda section: section.menu):
        for section in grouped:
            ui.frame(lambda section=section: menus.draw_commands(empty, section.commands))  # type: ignore[misc]
    assert drawn
    assert Counter(drawn) == Counter(found.command.label for found in find(every, "", empty))


def test_what_is_greyed_says_what_is_missing(empty: AppState, editing: AppState) -> None:
    def said(state: AppState, label: str) -> str:
        return next(one.tooltip(state) for one in commands(state) if one.label == label)

    assert said(empty, "Measure") == (
        "Measure between two clicks on the 3D view. Reconstruct a clip first, or open a run or a splat file."
    )
    assert said(empty, "Fit") == "Fit the whole frame. Open a clip first."
    assert said(empty, "Reconstruct").endswith(job_actions.why_not_reconstruct(empty))
    assert said(empty, "Select all") == "Turn on edit mode first (Ctrl+E)."
    assert said(editing, "Select all") == ""
    assert said(editing, "Hide") == "Hide the selected Gaussians. Select Gaussians first."
    assert said(editing, "Measure") == "Measure between two clicks on the 3D view"
    assert [one.tooltip(empty) for one in opening(empty)] == ["/clips/a", "/other/a"]


def test_recent_files_of_one_name_are_told_apart_by_their_folders(empty: AppState) -> None:
    assert [one.label.split("##")[0] for one in opening(empty)] == [
        str(Path("clips/a")),
        str(Path("other/a")),
    ]
    paths = ["/case 1/left/a.mp4", "/case 2/left/a.mp4", "/case 2/b.mp4", "/a.mp4", "/a.mp4"]
    kept = ["case 1/left/a.mp4", "case 2/left/a.mp4", "b.mp4", "/a.mp4", "/a.mp4"]
    assert told_apart(paths) == [str(Path(name)) for name in kept]
    assert told_apart([]) == []


def test_keys_are_called_as_on_this_system(ui: Ui, empty: AppState, monkeypatch: pytest.MonkeyPatch) -> None:
    """ImGui takes Cmd for Ctrl on macOS, where Cmd+M, H and Q are the system's own."""
    drawn: list[str] = []
    monkeypatch.setattr(imgui, "menu_item_simple", lambda label, keys, *rest: drawn.append(keys))
    monkeypatch.setattr(sys, "platform", "darwin")
    every = sections(empty, outside())
    for section in every:
        ui.frame(lambda section=section: menus.draw_commands(empty, section.commands))  # type: ignore[misc]
    assert {"Cmd+S", "Cmd+Shift+M", "Shift+M", ""} < set(drawn)
    assert "Ctrl+M" not in {keys for one in commands(empty) for keys in one.keys}
    assert not [keys for keys in drawn if "Ctrl" in keys or keys in ("Cmd+M", "Cmd+H")]
    assert [found.name for found in find(every, "cmd+shift+s", empty)] == ["Save session as…"]
    assert with_keys("Shift adds, Ctrl subtracts (Ctrl+A)") == "Shift adds, Cmd subtracts (Cmd+A)"
    assert with_keys(HOW_TEXT).count("Cmd") == HOW_TEXT.count("Ctrl") == 2
    assert with_keys("/cases/Ctrl-03 Ctrl/Ctrl.mp4") == "/cases/Ctrl-03 Ctrl/Ctrl.mp4"
    monkeypatch.setattr(sys, "platform", "linux")
    assert with_keys("Ctrl+A") == "Ctrl+A"


@pytest.mark.parametrize("which", ["empty", "state", "editing"])
def test_no_key_means_two_things_at_once(which: str, request: pytest.FixtureRequest) -> None:
    state: AppState = request.getfixturevalue(which)
    chords = Counter(chord(keys) for one in commands(state) for keys in one.keys if one.applies(state))
    assert [code for code, count in chords.items() if count > 1] == []


def test_a_key_is_shared_only_by_undo_of_two_kinds(empty: AppState) -> None:
    shared = Counter(keys for one in commands(empty) for keys in one.keys)
    assert {keys for keys, count in shared.items() if count > 1} == {"Ctrl+Z", "Ctrl+Y"}


@pytest.mark.parametrize("which", ["empty", "state"])
def test_every_command_can_be_run_at_any_time(which: str, request: pytest.FixtureRequest, ui: Ui) -> None:
    """Also those that do not apply: nothing is raised, and drawing goes on."""
    state: AppState = request.getfixturevalue(which)
    draw = palette(state)
    for command in commands(state):
        command.act(state)
        ui.frame(draw)


def test_words_find_commands_wherever_they_stand(empty: AppState) -> None:
    def labels(words: str) -> list[str]:
        return [found.name for found in find(sections(empty, outside()), words, empty)]

    assert labels("open folder")[0] == "Open folder…"
    assert labels("FOLDER open") == labels("open folder")
    assert "Plain white light" in labels("shift+w")
    assert "Lasso" in labels("edit tool")
    assert labels("no such thing at all") == []
    found = find(sections(empty, outside()), "", empty)
    applies = [one.applies for one in found]
    assert applies == sorted(applies, reverse=True)  # What can be done now comes first.


def test_the_palette_is_used_by_keyboard_alone(ui: Ui, state: AppState) -> None:
    draw, key = palette(state), imgui.Key
    ui.press(draw, key.mod_ctrl, key.mod_shift, key.p)
    assert state.window.palette.shown
    ui.frame(draw)
    ui.io.add_input_characters_utf8("stripes")
    ui.frame(draw)
    assert state.window.palette.words == "stripes"
    ui.press(draw, key.enter)
    assert not state.window.palette.shown
    assert state.comparing.chosen.zebra
    ui.frame(draw)
    assert not imgui.is_popup_open("", imgui.PopupFlags_.any_popup)


def test_words_of_no_command_lead_to_the_guide(ui: Ui, state: AppState) -> None:
    draw, key = palette(state), imgui.Key
    state.window.palette.open()
    ui.frame(draw)
    ui.frame(draw)
    ui.io.add_input_characters_utf8("language")
    ui.frame(draw)
    assert find(sections(state, outside()), state.window.palette.words, state) == []
    ui.press(draw, key.enter)
    assert state.guide.shown
    assert not state.window.palette.shown


def test_arrows_choose_and_escape_closes_and_does_nothing_else(ui: Ui, state: AppState) -> None:
    draw, key = palette(state), imgui.Key
    state.window.palette.open()
    ui.frame(draw)
    ui.frame(draw)
    ui.press(draw, key.down_arrow)
    ui.press(draw, key.down_arrow)
    assert state.window.palette.marked == 2
    for _ in range(3):
        ui.press(draw, key.up_arrow)
    assert state.window.palette.marked == len(commands(state)) - 1
    ui.press(draw, key.e)  # A letter is typed, not a key of the window.
    ui.press(draw, key.escape)
    ui.frame(draw)
    assert not state.window.palette.shown
    assert state.enhancement.active  # E was typed.


def test_what_does_not_apply_cannot_be_run(ui: Ui, empty: AppState) -> None:
    draw = palette(empty)
    empty.window.palette.open()
    ui.frame(draw)
    ui.frame(draw)
    ui.io.add_input_characters_utf8("stripes clipped")
    ui.frame(draw)
    ui.press(draw, imgui.Key.enter)
    assert empty.window.palette.shown
    assert not empty.comparing.chosen.zebra


def test_a_key_does_nothing_where_its_command_does_not_apply(ui: Ui, empty: AppState) -> None:
    ui.press(palette(empty), imgui.Key.z)
    assert not empty.comparing.chosen.zebra
    ui.press(palette(empty), imgui.Key.mod_shift, imgui.Key.a)
    assert not empty.enhancement.stored  # There are no panes to choose it for.


def test_undo_is_of_edits_in_edit_mode_and_of_parameters_elsewhere(editing: AppState) -> None:
    def undoing() -> list[str]:
        return [one.label for one in commands(editing) if "Ctrl+Z" in one.keys and one.applies(editing)]

    editing.enhancement.past = [replace(editing.chosen, scope="clip"), editing.chosen]
    assert undoing() == []
    editing.editing.active = False
    assert undoing() == ["Undo statistics"]


def test_every_key_has_a_name_that_can_be_pressed(empty: AppState) -> None:
    for command in commands(empty):
        for keys in command.keys:
            assert chord(keys) > 0
    with pytest.raises((KeyError, AttributeError)):
        chord("Hyper+Q")


def test_a_section_s_menu_stays_together(empty: AppState) -> None:
    """A menu is drawn once: its sections follow each other."""
    names = [name for name, _ in groupby(sections(empty, outside()), lambda one: one.menu)]
    assert len(set(names)) == len(names)


def test_sections_are_never_empty_but_for_what_is_recent(places: Places) -> None:
    bare: list[Section] = [one for one in sections(AppState(places), outside()) if not one.commands]
    assert [one.submenu for one in bare] == ["Open recent"]


SOUGHT = (
    ("ply", "3D model: splat file, this moment"),
    ("splats", "3D model: splat file, this moment"),
    ("mp4", "Export…"),
    ("full screen", "Full screen"),
    ("fullscreen", "Full screen"),
    ("dark", "Dark theme"),
    ("dark mode", "Dark theme"),
    ("theme", "Dark theme"),
    ("light theme", "Light theme"),
    ("light", "Light theme"),
    ("save picture", "Save image"),
    ("screenshot", "Save image"),
    ("undo", "Undo"),
    ("quit", "Quit"),
    ("exit", "Quit"),
    ("close", "Quit"),
    ("demo", "Try the built-in clip"),
    ("phantom", "Try the built-in clip"),
    ("load", "Open folder…"),
    ("batch", "Enhance files and folders…"),
    ("train", "Reconstruct"),
    ("3d model", "Reconstruct"),
    ("ruler", "Measure"),
    ("distance", "Measure"),
    ("wli", "Plain white light"),
    ("zoom 100%", "1:1"),
    ("pause", "Play"),
    ("font", "Larger text"),
    ("bigger letters", "Larger text"),
    ("text 200", "Text at 200 %"),
    ("text size 125%", "Text at 125 %"),
    ("vessel", "Enhancement"),
    ("shortcuts", "Keys and mouse"),
    ("defaults", "Reset all"),
    ("overexposed", "Zebra: stripes on clipped pixels"),
    ("presentation", "Presentation"),
    ("projector", "Second window"),
    ("brighter", "Enhancement"),
    ("magnify", "1:1"),
    ("before after", "Wipe"),
    ("split", "Side by side"),
    ("blink", "Flip"),
    ("record", "Record the live source"),
    ("report", "Report"),
    ("open folder", "Open folder…"),
    ("depth", "Reconstruct"),
    ("find tools", "Mask tools by hand"),
    ("brightness", "Enhancement"),
    ("vessels", "Enhancement"),
    ("sharpen", "Enhancement"),
    ("render", "Export…"),
    ("render 3d", "Image: 3D view"),
    ("picture", "Save image"),
    ("film", "Export…"),
    ("import film", "Open file…"),
    ("gif", "Video: panes as shown"),
    ("stl", "3D model: surface that moves"),
    ("web", "3D model: page for browsers"),
    ("excel", "Measures: table of both panes"),
    ("statistics", "Measures: table of both panes"),
    ("preferences", "Remember recent files"),
    ("caliper", "Measure"),
    ("diameter", "Measure"),
    ("flythrough", "Add a keyframe"),
    ("loupe", "1:1"),
    ("glare", "Zebra: stripes on clipped pixels"),
    ("loop", "Play"),
    ("comment", "Notes"),
    ("rotate", "Keys and mouse"),
    ("citation", "About VesselSplat"),
    ("quality", "Reconstruct"),
    ("delete run", "Delete the run"),
    ("rename", "Rename the run"),
    ("crop", "Crop to selection"),
    ("usb", "Open live source…"),
)
"""What people type, and the command that they mean."""


@pytest.mark.parametrize(("words", "label"), SOUGHT)
def test_the_palette_finds_what_people_call_it(state: AppState, words: str, label: str) -> None:
    """First among the commands that apply now, or first among those that do not."""
    found = find(sections(state, outside()), words, state)
    meant = next(one for one in found if one.name.startswith(label))
    alike = [one.name for one in found if one.applies == meant.applies]
    assert alike[0] == meant.name, alike[:4]


@pytest.mark.parametrize("which", ["empty", "state", "editing"])
def test_each_command_has_a_name_of_its_own(which: str, request: pytest.FixtureRequest) -> None:
    """But for what was opened lately, which the same file names in two menus."""
    state: AppState = request.getfixturevalue(which)
    names = Counter(one.label for one in commands(state) if "##" not in one.label)
    assert [name for name, count in names.items() if count > 1] == []


def test_synonyms_are_words_as_they_are_compared(state: AppState) -> None:
    """Lower case, one word each, and none twice."""
    for command in commands(state):
        assert all(word == word.casefold() and " " not in word for word in command.synonyms), command.label
        assert len(set(command.synonyms)) == len(command.synonyms), command.label
