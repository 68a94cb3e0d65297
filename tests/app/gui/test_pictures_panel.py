"""The two pictures: what each pane says and how they move together."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from imgui_bundle import ImVec2, imgui, imgui_ctx

from app.enhancement.frame_enhancer import PictureMaker
from app.enhancement.methods import VESSEL
from app.enhancement.settable import MODES, ORIGINAL, Mode
from app.exports.records import PanesPicture
from app.gui.actions import arriving, clip_actions, comparing
from app.gui.actions.export_records import request_of
from app.gui.panels import picture_pane
from app.gui.state.app_state import AppState
from app.gui.state.panes import FIRST_USE, LONG_SECONDS, Pane, original_tag, pane, source_label
from app.gui.state.tags import Tag
from app.gui.style.labels import tag_height
from app.gui.style.widgets import button, em
from app.gui.update.channels import Channels
from app.gui.views.comparison import SIDES
from app.gui.work.opening import Opened
from app.kernels.progress import Preparation, tasks
from enhance import EnhanceParams
from enhance.vessel import VesselParams
from tests.app.gui.settling import settle
from tests.app.gui.ui import (
    Shown,
    Ui,
    compare,
    pictures,
)


def said(shown: Pane) -> str:
    return " | ".join(one.text for one in shown.tags)


def test_left_is_the_original_and_right_the_enhanced(ui: Ui, opened: AppState) -> None:
    shown = Shown()
    ui.frame(compare(opened, shown))
    assert shown.images["left"] is pictures(opened).original
    assert shown.images["right"] is pictures(opened).enhanced


@pytest.mark.parametrize("mode", MODES)
def test_a_cross_shows_where_a_mask_begins(
    ui: Ui, opened: AppState, mode: Mode, monkeypatch: pytest.MonkeyPatch
) -> None:
    crosses: list[tuple[float, float]] = []
    monkeypatch.setattr(picture_pane, "_cross_at", lambda at: crosses.append((at.x, at.y)))
    comparing.choose_mode(opened, mode)
    clip_actions.draw_mask(opened, "text")
    ui.io.add_mouse_pos_event(200, 350)
    for _ in range(3):
        ui.frame(compare(opened, Shown()))
    assert (200, 350) in crosses


def test_the_right_pane_says_enhanced_exactly_when_it_is(opened: AppState) -> None:
    def right() -> Pane:
        return pane(opened, pictures(opened), "right")

    whole = pictures(opened)
    for enhancing in (True, False):
        for peeking in (True, False):
            for partner in (whole.enhanced, None):
                opened.enhancement.active, opened.enhancement.peeking = enhancing, peeking
                opened.picture.pictures = replace(whole, enhanced=partner)
                is_enhanced = right().image is partner
                assert ("ENHANCED" in said(right())) == is_enhanced
                assert "ORIGINAL" in said(pane(opened, pictures(opened), "left"))


def test_of_a_file_that_was_enhanced_before_nothing_is_called_original(opened: AppState) -> None:
    arriving.show_opened(opened, Path("again.png"), Opened(opened.source.clip, is_enhanced=True))
    request = opened.picture_request
    assert request is not None
    opened.picture.pictures = list(PictureMaker().make(request))[-1]
    for enhancing in (True, False):
        for peeking in (True, False):
            opened.enhancement.active, opened.enhancement.peeking = enhancing, peeking
            tags = [said(pane(opened, pictures(opened), side)) for side in SIDES]
            assert "ENHANCED BEFORE" in tags[0]
            assert "ORIGINAL" not in "".join(tags)
    assert source_label(opened, ORIGINAL) == "Enhanced before"
    opened.enhancement.active, opened.enhancement.peeking = True, False
    record = request_of(opened, "both panes", "again").record
    assert isinstance(record, PanesPicture)
    assert [one.title for one in record.panes] == ["Enhanced before", "Enhanced"]
    arriving.show_opened(opened, Path("clip"), Opened(opened.source.clip))
    assert original_tag(opened).text == "ORIGINAL"
    assert source_label(opened, ORIGINAL) == "Original"


def test_frozen_and_stale_are_tagged_on_both_sides(opened: AppState) -> None:
    opened.timeline.frozen_index, opened.window.now = 0, 5.0
    opened.enhancement.params = EnhanceParams(z=0.1)
    for side in SIDES:
        shown = said(pane(opened, pictures(opened), side))
        assert "FROZEN · frame 1" in shown
        assert "UPDATING" in shown


def test_a_long_wait_for_another_method_is_explained(opened: AppState) -> None:
    def right() -> str:
        return said(pane(opened, pictures(opened), "right"))

    opened.picture.asked_at, opened.window.now = 10.0, 10.0 + LONG_SECONDS / 2
    opened.enhancement.params = VesselParams()
    assert FIRST_USE not in right()
    opened.window.now = 10.1 + LONG_SECONDS
    assert "UPDATING" in right()
    assert FIRST_USE in right()
    opened.enhancement.params = EnhanceParams(z=0.1)  # The method on screen is at work.
    assert FIRST_USE not in right()
    opened.picture.pictures = replace(pictures(opened), enhanced=None)
    assert right().count(FIRST_USE) == 1


def test_the_wheel_zooms_at_the_pointer_and_a_double_click_fits(ui: Ui, opened: AppState) -> None:
    draw = compare(opened, Shown())
    ui.scroll(draw, (200, 400), 3.0)
    assert opened.picture.view.zoom is not None
    zoomed = opened.picture.zoom
    ui.drag(draw, (200, 400), (230, 420))
    assert opened.picture.zoom == pytest.approx(zoomed)
    assert opened.picture.view.center != (0.5, 0.5)
    for _ in range(2):
        ui.drag(draw, (200, 400), (200, 400))
    assert opened.picture.view.zoom is None


def test_both_panes_move_together_whichever_is_dragged(ui: Ui, opened: AppState) -> None:
    views = []
    for x in (200, 650):
        opened.picture.view = opened.picture.view.one_to_one(8.0)
        ui.drag(compare(opened, Shown()), (x, 400), (x + 25, 400))
        views.append(opened.picture.view)
        opened.picture.view = type(opened.picture.view)()
    assert views[0] == views[1]
    assert views[0].center[0] < 0.5


def test_during_the_preparation_the_original_is_shown_with_the_time_left(opened: AppState) -> None:
    channels = Channels()
    opened.enhancement.params = VesselParams()
    opened.window.preparation = Preparation(tasks(VESSEL))
    settle(opened, channels)
    right = said(pane(opened, pictures(opened), "right"))
    assert "PREPARING… original shown" in right
    assert "One-time preparation of this method: about 60 s left" in right
    assert not opened.pictures_are_stale  # It plays and scrubs meanwhile.
    opened.window.preparation = Preparation(tasks(VESSEL), 1)
    settle(opened, channels)
    assert "ENHANCED" in said(pane(opened, pictures(opened), "right"))


def test_a_low_pane_says_what_it_shows_and_not_how_that_was_made(
    ui: Ui, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[list[str]] = []
    monkeypatch.setattr(picture_pane, "stack_tags", lambda tags, *_: said.append([one.text for one in tags]))
    tags = (Tag("ENHANCED", "enhanced"), Tag("UPDATING…", "caution"), Tag("Vessel · Strength 2.40"))

    def draw() -> None:
        for height in (100, 600):
            picture_pane._draw_tags(tags, ImVec2(0, 0), ImVec2(400, height))

    ui.frame(draw)
    assert said == [["ENHANCED", "UPDATING…"], ["ENHANCED", "UPDATING…", "Vessel · Strength 2.40"]]


def test_a_narrow_side_of_the_wipe_cuts_its_tags_off_and_breaks_none(
    ui: Ui, opened: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken: list[bool] = []

    def watch(tags: Iterable[Tag], _: ImVec2, width: float) -> None:
        line = tag_height("a", 1e4)
        broken.append(any(tag_height(one.text, width - em(0.8)) > line for one in tags))

    monkeypatch.setattr(picture_pane, "stack_tags", watch)
    comparing.choose_mode(opened, "wipe")
    for place in (0.02, 0.98):
        comparing.set_wipe(opened, place)
        ui.frame(compare(opened, Shown()))
    first_left, _, _, second_right = broken
    assert not first_left
    assert not second_right


def test_both_settings_are_stored_from_one_line(
    ui: Ui, opened: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However narrow the panel is, as beside large text: neither is left alone on a line."""
    lines: dict[str, float] = {}

    def noted(label: str, *args: Any, **options: Any) -> bool:
        pressed = button(label, *args, **options)
        lines[label] = imgui.get_item_rect_min().y
        return pressed

    monkeypatch.setattr("app.gui.panels.compare.button", noted)

    def draw(width: float) -> None:
        with imgui_ctx.begin_child("narrow", ImVec2(width, 0)):
            compare(opened, Shown())()

    seen = set()
    for width in range(260, 900, 20):
        ui.frame(partial(draw, float(width)))
        assert lines["Store A"] == lines["Store B"], width
        seen.add(lines["Store B"] - lines["1:1"])
    assert len(seen) > 1
