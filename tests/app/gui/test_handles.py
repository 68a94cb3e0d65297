"""The handle of a slider and the number in its middle: both are seen, in both themes."""

from __future__ import annotations

from pathlib import Path

import pytest
from imgui_bundle import imgui

from app.gui.panels import timeline
from app.gui.style import theme
from app.gui.style.handles import slide_labelled
from app.gui.work.settings import Theme
from tests.app.gui.ui import Ui

LOGARITHMIC = int(imgui.SliderFlags_.logarithmic)


def is_lit(ui: Ui, value: float, low: float, high: float, flags: int) -> bool:
    """Or else the handle has the colour that stands out more."""
    found: list[bool] = []

    def draw() -> None:
        slide_labelled("##share", value, low, high, "frame %.0f %%", flags)
        drawn = {one.col for one in imgui.get_window_draw_list().vtx_buffer}
        lit, grab = (imgui.get_color_u32(one) in drawn for one in (theme.now().lit, theme.now().grab))
        assert lit != grab
        found.append(lit)

    ui.frame(draw)
    return found[0]


@pytest.mark.parametrize("worn", ["dark", "light"])
@pytest.mark.parametrize("flags", [0, LOGARITHMIC])
def test_a_handle_is_lit_while_it_is_below_the_number(ui: Ui, worn: Theme, flags: int) -> None:
    theme.wear(worn, 100)
    middle = 10.0 if flags else 50.5
    assert [is_lit(ui, value, 1, 100, flags) for value in (1, middle, 100)] == [False, True, False]


def test_a_range_of_one_value_has_a_handle(ui: Ui) -> None:
    assert not is_lit(ui, 3, 3, 3, 0)


def test_panels_have_no_slider_whose_handle_covers_its_number() -> None:
    """The timeline colours the handle of its own, and the brush has its number beside it."""
    panels = Path(timeline.__file__).parent.glob("*.py")
    own = {path.stem for path in panels if "imgui.slider_" in path.read_text("utf-8")}
    assert own == {"timeline", "masking"}
