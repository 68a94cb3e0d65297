"""A line over the bottom of the images says where vessels became fainter or hardly clearer, and offers what
helps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np
import pytest
from imgui_bundle import ImVec2, imgui

from app.enhancement.frame_enhancer import PictureMaker
from app.enhancement.measures import VesselsSeen
from app.enhancement.settable import Mode
from app.gui.actions import comparing, enhancement_actions
from app.gui.drawing.textures import OnPane
from app.gui.panels import faint_vessels as panel
from app.gui.state.app_state import AppState
from app.gui.state.panes import faint_vessels
from app.gui.style.widgets import button
from app.gui.work.measuring import Measurer
from enhance import EnhanceParams, VesselParams
from renderer.clip import ByteImage
from tests.app.gui.ui import Shown, Ui, compare

Drawn = tuple[tuple[int, int, int] | None, tuple[int, int, int] | None]


FAINTER, CLEARER = VesselsSeen(5.1, 3.8), VesselsSeen(5.1, 6.8)
"""Colour differences before and after."""


@pytest.fixture
def seen(opened: AppState) -> AppState:
    """Measured: vessels became fainter."""
    assert opened.picture.pictures is not None
    (measured,) = Measurer().measure(opened.picture.pictures)
    opened.picture.measured = replace(
        measured,
        vessels=FAINTER,
    )
    return opened


def test_it_is_said_of_the_picture_and_setting_on_screen(seen: AppState) -> None:
    assert faint_vessels(seen) == FAINTER
    enhancement_actions.set_params(seen, EnhanceParams(z=0.1))
    assert faint_vessels(seen) is None


def test_it_is_not_said_of_what_is_not_shown(seen: AppState) -> None:
    seen.enhancement.active = False
    assert faint_vessels(seen) is None
    seen.enhancement.active = True
    comparing.choose_source(seen, "right", "clahe")
    assert faint_vessels(seen) is None


def test_it_is_not_said_where_vessels_are_as_clear_as_before(seen: AppState) -> None:
    assert seen.picture.measured is not None
    seen.picture.measured = replace(seen.picture.measured, vessels=CLEARER)
    assert faint_vessels(seen) is None


def test_the_paper_s_method_in_full_strength_that_hardly_helps_is_said(seen: AppState) -> None:
    measured, in_full = seen.picture.measured, seen.enhancement.params
    assert measured is not None
    assert isinstance(in_full, EnhanceParams)
    assert in_full.strength >= 1
    for vessels, said in (
        (VesselsSeen(3.1, 3.2), True),
        (VesselsSeen(3.1, 2.9), True),
        (VesselsSeen(3.1, 3.5), False),
        (VesselsSeen(0.6, 0.6), False),
        (None, False),
    ):
        seen.picture.measured = replace(measured, vessels=vessels)
        assert faint_vessels(seen) == (vessels if said else None)


def test_vessel_and_half_the_strength_may_hardly_help(seen: AppState) -> None:
    for params in (VesselParams(), EnhanceParams(strength=0.5)):
        enhancement_actions.set_params(seen, params)
        assert seen.picture_request is not None
        assert seen.picture.measured is not None
        seen.picture.pictures = list(PictureMaker().make(seen.picture_request))[-1]
        known = replace(seen.picture.measured, pictures=seen.picture.pictures)
        seen.picture.measured = replace(known, vessels=VesselsSeen(3.1, 3.2))
        assert faint_vessels(seen) is None
        seen.picture.measured = replace(known, vessels=FAINTER)
        assert faint_vessels(seen) == FAINTER


VESSEL, CREASE = (180, 90, 85), (50, 16, 12)


def lines(vessel: tuple[int, int, int] | None, crease: tuple[int, int, int] | None) -> ByteImage:
    """Tissue with lines of either kind, some 5 pixels wide."""
    image = np.full((192, 256, 3), (200, 120, 110), np.uint8)
    for column in range(32, 240, 64):
        if vessel is not None:
            image[20:172, column : column + 5] = vessel
        if crease is not None:
            image[20:172, column + 32 : column + 37] = crease
    return np.asarray(cv2.GaussianBlur(image, (0, 0), 1.0), np.uint8)


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ((VESSEL, None), ((190, 105, 98), None), True),
        ((VESSEL, None), ((181, 90, 85), None), False),
        ((VESSEL, None), ((181, 91, 86), None), False),
        ((None, CREASE), (None, (90, 35, 30)), False),
        ((VESSEL, CREASE), ((170, 70, 65), (110, 50, 45)), False),
        ((VESSEL, CREASE), ((190, 105, 98), (110, 50, 45)), True),
        ((None, None), ((180, 90, 85), None), False),
    ],
)
def test_creases_that_brightening_opens_are_no_fainter_vessels(
    opened: AppState, before: Drawn, after: Drawn, said: bool
) -> None:
    assert opened.picture.pictures is not None
    pictures = replace(opened.picture.pictures, original=lines(*before), enhanced=lines(*after))
    (measured,) = Measurer().measure(pictures)
    assert (measured.vessels is not None and measured.vessels.are_fainter) == said


def test_what_an_image_hardly_gains_is_measured(opened: AppState) -> None:
    assert opened.picture.pictures is not None
    for factor, said in ((0.995, True), (0.8, False)):
        darker = tuple(round(factor * level) for level in VESSEL)
        pictures = replace(
            opened.picture.pictures, original=lines(VESSEL, CREASE), enhanced=lines(darker, (110, 50, 45))
        )
        (measured,) = Measurer().measure(pictures)
        assert measured.vessels is not None
        assert (measured.vessels.are_hardly_clearer, measured.vessels.are_fainter) == (said, False)


def click(ui: Ui, seen: AppState) -> None:
    """What is offered at the right end of the line."""
    spots: list[tuple[float, float]] = []

    def offered(label: str, act: Callable[[], object], text: str) -> None:
        button(label, act, text)
        low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        spots.append(((low.x + high.x) / 2, (low.y + high.y) / 2))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(panel, "button", offered)
        draw = compare(seen, Shown())
        ui.frame(draw)
        ui.drag(draw, spots[0], spots[0])


class Places(Shown):
    """Also where each slot is drawn."""

    def __init__(self) -> None:
        super().__init__()
        self.lows: list[tuple[float, float]] = []

    def lay(self, shown: OnPane, low: ImVec2, high: ImVec2) -> None:
        self.lows.append((low.x, low.y))


@pytest.mark.parametrize("mode", ["side by side", "wipe", "flip"])
def test_no_image_moves_as_it_comes_and_goes(ui: Ui, seen: AppState, mode: Mode) -> None:
    comparing.choose_mode(seen, mode)
    with_line, without = Places(), Places()
    ui.frame(compare(seen, with_line))
    assert seen.picture.measured is not None
    seen.picture.measured = replace(seen.picture.measured, vessels=CLEARER)
    ui.frame(compare(seen, without))
    assert with_line.lows == without.lows
    assert with_line.lows


def test_one_click_changes_to_the_preset(ui: Ui, seen: AppState) -> None:
    click(ui, seen)
    assert seen.enhancement.params == VesselParams()
    assert faint_vessels(seen) is None


def test_the_preset_is_offered_without_brightening_and_at_last_the_frame(ui: Ui, seen: AppState) -> None:
    for before, after in ((VesselParams(), VesselParams(lift=0.0)), (VesselParams(lift=0.0), None)):
        enhancement_actions.set_params(seen, before)
        assert seen.picture_request is not None
        seen.picture.pictures = list(PictureMaker().make(seen.picture_request))[-1]
        measured = seen.picture.measured
        assert measured is not None
        seen.picture.measured = replace(measured, pictures=seen.picture.pictures)
        assert faint_vessels(seen) is not None
        click(ui, seen)
        assert seen.enhancement.active == (after is not None)
        assert after is None or seen.enhancement.params == after
