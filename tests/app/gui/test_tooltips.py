"""Where tooltips go."""

from __future__ import annotations

import pytest
from imgui_bundle import ImVec2, imgui, imgui_ctx

from app.gui.panels import reconstruction_choices
from app.gui.panels.reconstruction import draw_reconstruction
from app.gui.state.app_state import AppState
from app.gui.style.widgets import explain_entry
from tests.app.gui.ui import Ui, tooltip

WIDTH = 200


@pytest.mark.parametrize(("left", "is_left"), [(5, False), (600, True)])
def test_a_tooltip_of_an_entry_covers_none_of_its_list(ui: Ui, left: int, is_left: bool) -> None:
    def draw() -> None:
        imgui.set_cursor_pos(ImVec2(left, 50))
        with imgui_ctx.begin_child("list", ImVec2(WIDTH, 300)):
            for entry in range(8):
                imgui.selectable(f"Entry {entry}", False)
                explain_entry("What is missing, in a sentence that is wider than a few words.")

    ui.io.add_mouse_pos_event(left + 30, 60)
    for _ in range(60):
        ui.frame(draw)
    shown = tooltip()
    assert shown is not None
    assert shown.pos.x >= 0
    assert shown.pos.x + shown.size.x <= 900
    assert (shown.pos.x + shown.size.x <= left) == is_left
    assert is_left or shown.pos.x >= left + WIDTH


def test_tooltips_just_above_the_button_do_not_cover_it(
    ui: Ui, state: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the number of iterations and of the name, which are set before it is pressed."""
    places: list[ImVec2] = []

    def noted(text: str) -> None:
        places.append((imgui.get_item_rect_min() + imgui.get_item_rect_max()) / 2)
        explain_entry(text)

    def draw() -> None:
        places.clear()
        imgui.set_cursor_pos(ImVec2(600, 50))
        with imgui_ctx.begin_child("panel", ImVec2(290, 600)):
            draw_reconstruction(state)

    monkeypatch.setattr(reconstruction_choices, "explain_entry", noted)
    ui.frame(draw)
    assert len(places) == 3
    for place in list(places):
        ui.io.add_mouse_pos_event(place.x, place.y)
        for _ in range(60):
            ui.frame(draw)
        shown = tooltip()
        assert shown is not None
        assert shown.pos.x + shown.size.x <= 600
