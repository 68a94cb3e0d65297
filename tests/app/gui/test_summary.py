"""The case summary in the window: what is shown is added, ordered, noted, kept with the session, written."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from imgui_bundle import imgui

from app.enhancement.measures import Original
from app.exports.html_file import facts_in
from app.exports.make import make
from app.exports.records import EXPORT, PanesPicture
from app.exports.replay.again import replay
from app.exports.replay.recorded import recorded
from app.exports.replay.sources import Found
from app.exports.sizing import Sizing
from app.exports.summary.page import COLUMNS
from app.files.provenance import read_provenance
from app.files.stepping import run_to_end
from app.gui.actions import (
    actions,
    escape,
    export_actions,
    floating_windows,
    session_actions,
    summary_actions,
)
from app.gui.commands.keys import chord
from app.gui.frame.quitting import case_in_words
from app.gui.panels.summary import draw_summary
from app.gui.session_file import MOST_ITEMS, mended_session, write_session
from app.gui.state.app_state import AppState
from app.gui.state.summary import Item
from app.gui.work.background import Failure
from app.gui.work.naming import name_of
from app.gui.work.settings import Places, Settings
from enhance.noise import NoiseCut
from tests.app.gui.exporting import Exporter
from tests.app.gui.ui import Shown, Ui


def add(window: Exporter) -> None:
    summary_actions.add_shown(window.state)
    window.turn(20)


def test_what_is_shown_is_saved_and_added_and_the_page_is_written(run: Exporter) -> None:
    state = run.state
    add(run)
    actions.seek(state, 3)
    run.turn(8)
    add(run)
    first, second = state.summary.items
    assert first.path.parent == state.export_folder
    assert first.path != second.path
    summary_actions.type_note(state, 1, "a vessel")
    summary_actions.type_title(state, "Case: 7")  # No name of a file.
    summary_actions.move(state, 1, -1)
    summary_actions.move(state, 0, -1)
    assert [item.note for item in state.summary.items] == ["a vessel", ""]
    summary_actions.write_page(state)
    run.turn(20)
    assert state.window.banner is None
    path = state.exports.last
    assert path is not None
    assert path.name == "case-summary.html"
    facts = facts_in(path.read_text())
    told = [(one["picture"]["name"], one["note"]) for one in facts["pictures"]]
    assert told == [(second.path.name, "a vessel"), (first.path.name, "")]
    assert facts["title"] == "Case: 7"
    assert replay(path, (), path.with_name("again.html")).difference.is_none


def test_while_the_page_is_written_the_name_that_its_file_gets_is_said(run: Exporter) -> None:
    """The export panel is not open."""
    run.rest()
    add(run)
    summary_actions.write_page(run.state)
    run.turn(20)
    first = run.state.exports.last
    assert first is not None
    run.state.exports.shown = False
    summary_actions.write_page(run.state)
    wish = export_actions.name_wish(run.state)
    assert wish is not None
    (name,) = name_of(wish)
    export_actions.take_name(run.state, wish, name)
    assert export_actions.name_written(run.state) == f"{first.stem}-2.html"


def test_notes_of_the_case_are_added_once(state: AppState) -> None:
    assert summary_actions.why_not_add_notes(state) == "The case has no notes yet: View > Notes."
    state.session.notes = "Vessel at 3 o'clock.\nPolyp."
    summary_actions.type_notes(state, "For the file.")
    for _ in range(2):
        summary_actions.add_notes(state)
    assert state.summary.notes == "For the file.\nVessel at 3 o'clock.\nPolyp."
    assert summary_actions.why_not_add_notes(state) == "They are on the page."


def test_the_measures_are_those_of_the_panes(run: Exporter) -> None:
    """By what they are defined by, of the frame and of the enhanced one that the window shows."""
    run.rest()
    add(run)
    (item,) = run.state.summary.items
    told = read_provenance(item.path)["panes"]
    original, pictures = run.state.source.clip.read_image(0), run.state.picture.pictures  # type: ignore[union-attr]
    assert pictures is not None
    for pane, image in zip(told, (pictures.original, pictures.enhanced), strict=True):
        wanted = asdict(Original.of(original).measures(image))
        for name, value in pane["measured"].items():
            # JSON has no NaN.
            assert np.isclose(np.nan if value is None else value, wanted[name], equal_nan=True), name
    summary_actions.write_page(run.state)
    run.turn(20)
    assert run.state.exports.last is not None
    page = run.state.exports.last.read_text()
    numbers = [(told[1]["measured"][name], form) for name, _, form in COLUMNS]
    assert all(value is None or f">{value:{form}}<" in page for value, form in numbers)


def test_measures_come_again_by_the_noise_that_the_image_says(run: Exporter) -> None:
    """Images of before say nothing of it."""
    run.rest()
    add(run)
    (item,), clip = run.state.summary.items, run.state.source.clip
    assert clip is not None
    record = EXPORT.validate_python(recorded(item.path))
    assert isinstance(record, PanesPicture)
    gains = []
    for cut in get_args(NoiseCut):
        again = item.path.with_name(f"{cut}.png")
        run_to_end(make(replace(record, noise_cut=cut, views=()), Found(item.path, (clip.path,)), again))
        gains.append([pane["measured"]["noise_gain"] for pane in read_provenance(again)["panes"]])
    assert record.noise_cut == "unclipped"
    assert gains[1] != gains[2]


def test_the_measures_are_those_of_the_pixels_whatever_the_size_of_the_file(run: Exporter) -> None:
    run.rest()
    add(run)
    run.state.exports.sizing = Sizing(2)
    add(run)
    once, twice = (read_provenance(item.path)["panes"] for item in run.state.summary.items)
    assert [pane["measured"] for pane in once] == [pane["measured"] for pane in twice]


def test_what_is_too_large_to_be_drawn_is_not_added(run: Exporter) -> None:
    run.state.exports.view_size, run.state.exports.supersampling = (3840, 2160), 4
    summary_actions.add_shown(run.state)
    assert run.state.summary.awaited == ()
    assert run.state.window.banner is not None
    assert "million pixels" in run.state.window.banner.message


def test_a_page_has_the_name_of_its_title_where_that_can_be_one(run: Exporter) -> None:
    add(run)
    summary_actions.type_title(run.state, "Colon")
    run.state.exports.failure = "no space left"  # Of the export before.
    summary_actions.write_page(run.state)
    assert not run.state.exports.failure
    run.turn(20)
    assert run.state.exports.last == run.state.export_folder / "Colon.html"


def test_an_image_is_added_once_and_only_of_a_kind_that_browsers_show(
    state: AppState, tmp_path: Path
) -> None:
    for name in ("a.png", "a.png", "b.JPG", "c.tiff", "d.npy"):
        summary_actions.add_file(state, tmp_path / name)
    assert [item.path.name for item in state.summary.items] == ["a.png", "b.JPG"]
    assert state.window.banner is not None
    assert "expected a PNG or JPEG image that VesselSplat saved, got d.npy" in state.window.banner.message


def test_what_cannot_be_saved_is_not_waited_for(state: AppState) -> None:
    summary_actions.add_shown(state)
    (request,) = state.summary.awaited
    assert summary_actions.why_not_write(state) == "An image is still being saved."
    summary_actions.take_saved(state, request, Failure(OSError("the disk is full")))
    assert state.summary.awaited == ()
    assert state.summary.items == ()
    assert state.window.banner is not None
    assert "the disk is full" in state.window.banner.message


def test_there_is_a_reason_wherever_nothing_can_be_done(places: Places, state: AppState) -> None:
    empty = AppState(places, Settings(acknowledged=True))
    assert summary_actions.why_not_add(empty) == "Open a clip, an image or a run first."
    assert summary_actions.why_not_write(empty) == "Add an image first."
    summary_actions.write_page(empty)
    assert empty.exports.under_way is None
    state.summary.items = tuple(Item(Path(f"{number}.png")) for number in range(MOST_ITEMS))
    assert str(MOST_ITEMS) in summary_actions.why_not_add(state)


def test_the_session_keeps_it(run: Exporter, tmp_path: Path) -> None:
    state = run.state
    add(run)
    summary_actions.type_note(state, 0, "here")
    summary_actions.type_notes(state, "on all")
    lost = state.export_folder / "lost.png"
    summary_actions.add_file(state, lost)
    path = tmp_path / "kept" / "a.vesselsplat"
    path.parent.mkdir()
    write_session(path, session_actions.snapshot(state, path.parent))
    session, damage = mended_session(path)
    assert damage == ""
    other = Exporter(state.places, path)
    assert other.state.summary.items == (Item(state.summary.items[0].path, "here"),)
    assert other.state.summary.notes == "on all"
    assert any(
        "1 of 2 images of the case summary are no longer there" in line for line in other.state.window.log
    )
    assert session.substance == session_actions.snapshot(state, tmp_path).substance
    summary_actions.type_note(state, 0, "there")
    assert session.substance != session_actions.snapshot(state, tmp_path).substance


@pytest.mark.parametrize("texts", [False, True])
def test_the_panel_opens_by_its_key_is_drawn_and_left(ui: Ui, run: Exporter, texts: bool) -> None:
    state = run.state
    assert chord("Ctrl+Shift+J") is not None
    floating_windows.toggle(state.summary)
    if texts:
        add(run)
        run.turn(20)
        assert state.summary.thumbnails[state.summary.items[0].path] is not None
    for _ in range(3):
        ui.frame(lambda: draw_summary(state, Shown()))
    assert imgui.get_io().want_capture_mouse is not None
    assert escape.leave_innermost(state)
    assert not state.summary.shown


def test_what_is_lost_names_no_notes_where_there_are_none(state: AppState) -> None:
    assert case_in_words(state) == "the case summary"
    state.summary.items = (Item(Path("a.png")),)
    assert case_in_words(state) == "1 image of the case summary"
    state.session.notes = "left ureter?"
    state.summary.items *= 2
    assert case_in_words(state) == "the notes and 2 images of the case summary"
