"""A hand on the sliders: a drag, a double click, a typed number; what is read beside and below them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import pytest
from imgui_bundle import ImVec2, hello_imgui, imgui, imgui_ctx
from PIL import ImageFont

from app.enhancement.amounts import AMOUNTS
from app.enhancement.frame_enhancer import PictureMaker
from app.enhancement.methods import EnhancementSettings
from app.enhancement.setting_words import LABELS, before_strength
from app.gui.actions import enhancement_actions, history_actions
from app.gui.panels import enhancement
from app.gui.panels.enhancement import draw_enhancement
from app.gui.state import scales
from app.gui.state.app_state import AppState
from app.gui.state.panes import pane
from app.gui.style import fields, fonts
from app.gui.style.widgets import NAMES
from enhance import EnhanceParams, Statistics
from enhance.vessel import VesselParams
from tests.app.gui.ui import Shown, Ui, pictures, tooltip

Spot = tuple[float, float]
AUTOMATIC = ("z", "p", "d_factor")
GRAB = 5.5
"""Half the width of a slider's handle."""


@dataclass(frozen=True)
class Number:
    """That stands beside a slider."""

    text: str
    gap: float
    """From the slider's end on."""
    end: float


@dataclass
class Hand:
    """On the sliders of a panel; finds each by its id, the first where there are more."""

    ui: Ui
    state: AppState
    panel: Callable[[AppState], None]
    low: dict[str, ImVec2] = field(default_factory=dict)
    high: dict[str, ImVec2] = field(default_factory=dict)
    numbers: list[Number] = field(default_factory=list)
    end: ImVec2 = field(default_factory=lambda: ImVec2(0, 0))
    """Of the slider that was drawn last."""

    def draw(self) -> None:
        for found in (self.low, self.high, self.numbers):
            found.clear()
        self.panel(self.state)
        if not imgui.is_any_item_active():
            enhancement_actions.settle_params(self.state)

    def show(self, params: EnhancementSettings) -> None:
        """The image of these settings, too."""
        enhancement_actions.set_params(self.state, params)
        assert self.state.picture_request is not None
        self.state.picture.pictures = list(PictureMaker().make(self.state.picture_request))[-1]
        self.frame(2)

    @property
    def used(self) -> Statistics:
        used = pictures(self.state).statistics
        assert used is not None
        return used

    def frame(self, count: int = 1) -> None:
        for _ in range(count):
            self.ui.frame(self.draw)

    def at(self, name: str, share: float) -> Spot:
        """Where the middle of the handle is at a share of the slider's range."""
        low, high = self.low[name], self.high[name]
        ends = low.x + 2 + GRAB, high.x - 2 - GRAB
        return ends[0] + share * (ends[1] - ends[0]), (low.y + high.y) / 2

    def press(self, spot: Spot, frames: int = 3) -> None:
        """As long as a hand does, which is more than one frame."""
        self.ui.io.add_mouse_pos_event(*spot)
        self.frame(2)
        self.ui.io.add_mouse_button_event(0, True)
        self.frame(frames)

    def release(self) -> None:
        self.ui.io.add_mouse_button_event(0, False)
        self.frame(2)

    def drag(self, name: str, start: float, end: float) -> None:
        self.press(self.at(name, start))
        for step in range(1, 6):
            self.ui.io.add_mouse_pos_event(*self.at(name, start + step / 5 * (end - start)))
            self.frame()
        self.release()

    def double_click(self, name: str, share: float) -> None:
        for _ in range(2):
            self.press(self.at(name, share), 4)
            self.release()

    def type(self, name: str, text: str) -> None:
        self.ui.io.add_key_event(imgui.Key.mod_ctrl, True)
        self.press(self.at(name, 0.5))
        self.release()
        self.ui.io.add_key_event(imgui.Key.mod_ctrl, False)
        self.frame()
        self.ui.io.add_input_characters_utf8(text)
        self.frame(2)
        self.ui.press(self.draw, imgui.Key.enter)
        self.frame()


@pytest.fixture
def watched(monkeypatch: pytest.MonkeyPatch) -> list[Hand]:
    """The hands that are to know where sliders are."""
    hands: list[Hand] = []
    slider, number = fields.slider, fields.number

    def seen(label: str, *rest: Any) -> tuple[bool, Any]:
        moved = slider(label, *rest)
        for hand in hands:
            hand.low.setdefault(label.removeprefix("##"), imgui.get_item_rect_min())
            hand.high.setdefault(label.removeprefix("##"), imgui.get_item_rect_max())
            hand.end = imgui.get_item_rect_max()
        return moved

    def read(text: str, *, quiet: bool = False) -> None:
        number(text, quiet=quiet)
        for hand in hands:
            low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
            hand.numbers.append(Number(text, low.x - hand.end.x, high.x))

    for module in (fields, enhancement):
        monkeypatch.setattr(module, "slider", seen)
    for module in (fields, enhancement):
        monkeypatch.setattr(module, "number", read)
    return hands


@pytest.fixture
def hand(ui: Ui, opened: AppState, watched: list[Hand]) -> Hand:
    made = Hand(ui, opened, lambda state: draw_enhancement(state, Shown()))
    watched.append(made)
    made.frame(2)
    return made


def shown(params: EnhanceParams, name: str) -> float:
    """On the slider of a parameter that is set."""
    value = getattr(params, name)
    assert value is not None
    return AMOUNTS[name].of_parameter(value) if name in AMOUNTS else value / 4


@pytest.mark.parametrize("name", AUTOMATIC)
def test_a_drag_takes_over_from_automatic_in_one_step(hand: Hand, name: str) -> None:
    hand.drag(name, 0.3, 0.75)
    params = hand.state.enhancement.params
    assert isinstance(params, EnhanceParams)
    assert shown(params, name) == pytest.approx(0.75, abs=0.02)
    assert replace(params, **{name: None}) == EnhanceParams()
    history_actions.undo(hand.state)
    assert hand.state.enhancement.params == EnhanceParams()


@pytest.mark.parametrize("name", AUTOMATIC)
def test_a_double_click_gives_automatic_back(hand: Hand, name: str) -> None:
    enhancement_actions.set_params(hand.state, EnhanceParams(**{name: 0.4}))
    hand.double_click(name, 0.9)
    hand.frame(60)
    assert hand.state.enhancement.params == EnhanceParams()


@pytest.mark.parametrize("name", AUTOMATIC)
@pytest.mark.parametrize("given", [{}, {"z": 0.4, "p": 0.4, "d_factor": 0.4}])
def test_a_number_is_typed(hand: Hand, name: str, given: dict[str, float]) -> None:
    enhancement_actions.set_params(hand.state, EnhanceParams(**given))  # type: ignore[arg-type]
    hand.type(name, "0.25")
    wanted = {"z": 0.75, "p": 0.25, "d_factor": 3.0}[name]
    assert hand.state.enhancement.params == EnhanceParams(**given | {name: wanted})  # type: ignore[arg-type]


def test_a_word_is_chosen_in_a_typed_number_by_a_double_click(hand: Hand) -> None:
    enhancement_actions.set_params(hand.state, EnhanceParams(z=0.4))
    hand.ui.io.add_key_event(imgui.Key.mod_ctrl, True)
    hand.double_click("z", 0.5)
    hand.ui.io.add_key_event(imgui.Key.mod_ctrl, False)
    hand.frame(2)
    assert hand.state.enhancement.params == EnhanceParams(z=0.4)


def test_the_switch_takes_over_what_is_in_use(hand: Hand) -> None:
    for strength in (1.0, 0.5):
        automatic = EnhanceParams(strength=strength)
        hand.show(automatic)
        used = hand.used
        low, high = hand.low["z"], hand.high["z"]
        spot = (high.x + 8 + (high.y - low.y) / 2, (low.y + high.y) / 2)
        hand.press(spot)
        hand.release()
        params = hand.state.enhancement.params
        assert params != automatic
        hand.show(params)
        assert hand.used.z == pytest.approx(used.z, abs=0.01)


def test_what_one_window_takes_over_is_not_strengthened_twice(hand: Hand) -> None:
    automatic = EnhanceParams(strength=0.5, p=None)
    hand.show(automatic)
    whole = before_strength(automatic, hand.used)
    taken = scales.with_exponent(automatic, 0, 0.8, scales.exponents(automatic, whole.p))
    before = hand.used.p[1:]
    hand.show(taken)
    assert hand.used.p == pytest.approx((0.4, *before))


def test_numbers_stand_beside_their_sliders_in_one_column(hand: Hand) -> None:
    for params in (EnhanceParams(), EnhanceParams(z=0.0, p=(0.1, 2.0, 4.0), d_factor=0.5), VesselParams()):
        enhancement_actions.set_params(hand.state, params)
        hand.frame(2)
        assert len(hand.numbers) == len([one for one in hand.numbers if one.gap > 0]) > 5
        assert len({round(one.end) for one in hand.numbers[1:]}) == 1  # The first is above what scrolls.


def test_the_numbers_are_amounts(hand: Hand) -> None:
    enhancement_actions.set_params(hand.state, EnhanceParams(z=0.07, p=0.5, d_factor=0.25))
    hand.frame(2)
    assert [one.text for one in hand.numbers[:4]] == ["1.00", "0.93", "0.50", "0.80"]


@pytest.mark.parametrize("width", [190, 230, 260])
def test_in_a_narrow_panel_sliders_are_below_their_numbers(
    ui: Ui, opened: AppState, watched: list[Hand], width: int
) -> None:
    def narrow(state: AppState) -> None:
        with imgui_ctx.begin_child("narrow", ImVec2(width, 0)):
            draw_enhancement(state, Shown())

    hand = Hand(ui, opened, narrow)
    watched.append(hand)
    hand.frame(2)
    assert all(hand.high[name].x - hand.low[name].x > 3 * 13 for name in hand.low)
    assert all(one.end <= width + 8 for one in hand.numbers)
    hand.drag("z", 0.3, 0.75)
    assert shown(opened.enhancement.params, "z") == pytest.approx(0.75, abs=0.02)  # type: ignore[arg-type]


def test_a_tooltip_is_below_its_slider_and_gone_while_it_is_dragged(hand: Hand) -> None:
    hand.frame(2)
    spot = hand.at("z", 0.5)
    hand.ui.io.add_mouse_pos_event(*spot)
    hand.frame(60)
    assert tooltip() is not None
    assert tooltip().pos.y > hand.high["z"].y
    hand.press(spot, 60)
    assert tooltip() is None
    hand.release()


@pytest.mark.parametrize(
    "params",
    [
        EnhanceParams(),
        EnhanceParams(strength=0.5),
        EnhanceParams(z=0.07, p=0.2, d_factor=1.0),
        VesselParams(),
    ],
)
def test_the_badge_on_the_image_says_what_the_sliders_say(hand: Hand, params: EnhancementSettings) -> None:
    hand.show(params)
    names = ["Strength", "Radius", "Brightening", "Colour"]
    if isinstance(params, EnhanceParams):
        names = ["Strength", "Brightness", "Detail", "Colour"]
    numbers = {name: one.text for name, one in zip(names, hand.numbers, strict=False)}
    badge = pane(hand.state, pictures(hand.state), "right").tags[-1].text
    said = dict(part.replace("auto ", "").split(" ")[:2] for part in badge.split(" · ") if " " in part)
    assert said.keys() >= {"Colour"}
    assert said == {name: numbers[name] for name in said}


def test_names_of_settings_end_before_their_sliders() -> None:
    font = ImageFont.truetype(hello_imgui.asset_file_full_path(fonts.OWN), 100)
    wide = {label: font.getlength(label) / sum(font.getmetrics()) for label in LABELS.values()}
    assert max(wide.values()) > 5  # Text heights: it is the window's own font.
    assert [label for label, width in wide.items() if width > NAMES - 0.5] == []
