"""Both themes: every text can be read on what lies behind it, and no grey has a hue."""

from __future__ import annotations

from functools import partial

import pytest
from imgui_bundle import ImVec2, ImVec4, imgui

from app.gui.actions import actions
from app.gui.panels import enhancement, export
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.style.widgets import button, toggle
from app.gui.work.presets import BUILT_IN, preset_name
from app.gui.work.settings import Settings, Theme, load_settings
from tests.app.gui.settling import keep_all
from tests.app.gui.ui import Shown, Ui

READABLE = 4.5
"""WCAG 2.2, success criterion 1.4.3, level AA."""
TOLD_APART = 3.0
"""The same, 1.4.11."""
BOTH: tuple[Theme, ...] = ("dark", "light")
PANELS = ("window_bg", "popup_bg", "menu_bar_bg", "title_bg", "title_bg_active", "tab_dimmed_selected", "tab",
          "tab_selected", "tab_hovered", "table_header_bg")  # fmt: skip
CONTROLS = ("frame_bg", "frame_bg_hovered", "frame_bg_active", "button", "button_hovered", "button_active",
            "header", "header_hovered", "header_active", "text_selected_bg")  # fmt: skip


def luminance(color: ImVec4) -> float:
    """Relative, of sRGB, as WCAG 2.2 defines it."""
    linear = [
        c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (color.x, color.y, color.z)
    ]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(ink: ImVec4, ground: ImVec4) -> float:
    low, high = sorted((luminance(ink), luminance(ground)))
    return (high + 0.05) / (low + 0.05)


def style(name: str) -> ImVec4:
    return imgui.get_style().color_(getattr(imgui.Col_, name))


def test_contrast_is_that_of_the_standard() -> None:
    assert contrast(theme.grey(0), theme.grey(1)) == pytest.approx(21)
    assert contrast(theme.grey(0x76 / 255), theme.grey(1)) == pytest.approx(4.54, abs=0.01)


@pytest.mark.parametrize("name", BOTH)
def test_every_text_can_be_read(ui: Ui, name: Theme) -> None:
    theme.wear(name, 100)
    worn = theme.now()
    bright = {f"text on {ground}": contrast(worn.text, style(ground)) for ground in (*PANELS, *CONTROLS)}
    soft = (
        "window_bg",
        "popup_bg",
        "menu_bar_bg",
        "tab",
        "header",
        "header_hovered",
        "header_active",
        "frame_bg",
    )
    bright |= {f"muted on {ground}": contrast(worn.muted, style(ground)) for ground in soft}
    for ink in ("accent", "warning", "danger"):
        for ground in ("window_bg", "popup_bg", "menu_bar_bg"):
            bright[f"{ink} on {ground}"] = contrast(getattr(worn, ink), style(ground))
    for ground in ("lit", "caution", "recording", "alarm"):
        bright[f"text on {ground}"] = contrast(worn.text, getattr(worn, ground))
    assert {pair: round(value, 2) for pair, value in bright.items() if value < READABLE} == {}


@pytest.mark.parametrize("name", BOTH)
def test_what_says_something_without_words_stands_out(ui: Ui, name: Theme) -> None:
    """Handles, bars of scrolling, edges of boxes to tick, and the bars on what is on or chosen."""
    theme.wear(name, 100)
    worn = theme.now()
    pairs = [(style("slider_grab"), style("frame_bg")), (style("scrollbar_grab"), style("window_bg"))]
    pairs += [(worn.text, worn.lit), (worn.text, worn.caution)]
    pairs += [(worn.edge, worn.ground)]
    pairs += [
        (worn.accent, style(ground)) for ground in ("popup_bg", "header", "header_hovered", "window_bg")
    ]
    assert [round(contrast(*pair), 2) for pair in pairs if contrast(*pair) < TOLD_APART] == []


@pytest.mark.parametrize("level", [0.10, 0.17, 0.21, 0.25, 0.30, 0.34, 0.45, 0.75])
def test_greys_stand_out_from_panels_alike_in_both(level: float) -> None:
    """Fields, buttons, borders, lines in the plots."""
    dark, light = (contrast(one.shade(level), one.ground) for one in (theme.DARK, theme.LIGHT))
    assert light == pytest.approx(dark, rel=0.01)


@pytest.mark.parametrize("role", ["lit", "caution", "recording"])
def test_what_is_on_stands_out_from_buttons_alike_in_both(role: str) -> None:
    dark, light = (contrast(getattr(one, role), one.shade(0.25)) for one in (theme.DARK, theme.LIGHT))
    assert min(dark, light) > 1.3
    assert light == pytest.approx(dark, rel=0.25)


def test_what_is_on_says_so_by_more_than_its_color(ui: Ui) -> None:
    """More is drawn of it: a bar."""
    drawn: list[int] = []

    def draw() -> None:
        for on in (False, True):
            before = imgui.get_window_draw_list().vtx_buffer.size()
            toggle("Zebra", lambda: None, on=on)
            drawn.append(imgui.get_window_draw_list().vtx_buffer.size() - before)

    ui.frame(draw)
    off, on = drawn
    assert 0 < off < on


@pytest.mark.parametrize("name", ["dark", "light"])
def test_a_coloured_button_keeps_its_colour_below_the_pointer(
    ui: Ui, name: Theme, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[ImVec4] = []
    states = ("button_hovered", "button_active")

    def drawn(label: str, size: ImVec2) -> bool:
        seen.extend(ImVec4(*style(state)) for state in states)
        return False

    monkeypatch.setattr(imgui, "button", drawn)
    theme.wear(name, 100)
    worn = theme.now()
    ui.frame(lambda: button("Reconstruct", color=worn.lit))
    for color in seen:
        assert 0 < abs(color.z - worn.lit.z) < 0.25
        assert color.z - color.x > 0.5 * (worn.lit.z - worn.lit.x)
        assert contrast(worn.text, color) > contrast(worn.text, worn.lit)
    assert len(seen) == len(states)


def test_the_chosen_line_of_a_list_has_a_bar(
    ui: Ui, opened: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    marked: list[str] = []
    for panel in (export, enhancement):
        monkeypatch.setattr(panel, "mark_row", partial(marked.append, panel.__name__))
    opened.exports.shown = True
    preset = preset_name(opened.enhancement.params, {})

    def draw() -> None:
        export.draw_export(opened)
        for name in BUILT_IN:
            enhancement._draw_preset(opened, name, preset, Shown())

    ui.frame(draw)
    assert marked == [export.__name__, enhancement.__name__]


@pytest.mark.parametrize(
    "ground", [theme.TAG_ORIGINAL, theme.TAG_ENHANCED, theme.TAG_CAUTION, theme.SURROUND]
)
def test_tags_on_pictures_can_be_read(ground: ImVec4) -> None:
    assert contrast(theme.INK, ground) >= READABLE


def test_pictures_have_the_same_neutral_surround_in_both(ui: Ui) -> None:
    surrounds = set()
    for name in BOTH:
        theme.wear(name, 100)
        empty = style("docking_empty_bg")
        surrounds.add((empty.x, empty.y, empty.z))
    assert surrounds == {(theme.SURROUND.x,) * 3}


def test_nothing_keeps_a_color_of_imgui_s_own(ui: Ui) -> None:
    """Set to a colour that no theme has, every role is changed by each theme."""
    strange = ImVec4(0.9, 0.1, 0.9, 0.123)
    roles = [role for role in imgui.Col_ if role != imgui.Col_.count]
    for name in BOTH:
        for role in roles:
            imgui.get_style().set_color_(role, strange)
        theme.wear(name, 100)
        left = [role.name for role in roles if imgui.get_style().color_(role).w == pytest.approx(0.123)]
        assert left == []


@pytest.mark.parametrize("name", BOTH)
def test_what_surrounds_pictures_has_no_hue(ui: Ui, name: Theme) -> None:
    theme.wear(name, 100)
    for role in (*PANELS, *CONTROLS[:-1], "border", "separator"):
        color = style(role)
        assert color.x == color.y == color.z


def test_the_window_wears_one_theme_at_a_time_and_text_of_one_size(ui: Ui) -> None:
    for name, percent in (("light", 150), ("dark", 80), ("light", 200)):
        theme.wear(name, percent)  # type: ignore[arg-type]
        assert theme.now() is theme.THEMES[name]  # type: ignore[index]
        sizes: list[float] = []
        ui.frame(lambda sizes=sizes: sizes.append(imgui.get_font_size()))  # type: ignore[misc]
        assert sizes == [pytest.approx(imgui.get_style().font_size_base * percent / 100, abs=1)]


@pytest.mark.parametrize("percent", [80, 150, 200])
def test_gaps_grow_with_the_text(ui: Ui, percent: int) -> None:
    """Else the words of the menu bar stand as close together as those of a sentence."""
    theme.wear("dark", 100)
    usual = imgui.get_style().item_spacing.x, imgui.get_style().frame_padding.x
    theme.wear("dark", percent)
    gaps = imgui.get_style().item_spacing.x, imgui.get_style().frame_padding.x
    assert gaps == tuple(pytest.approx(percent / 100 * gap, abs=0.5) for gap in usual)
    theme.wear("dark", 100, density=2.0)
    assert imgui.get_style().item_spacing.x == 2 * usual[0]


def test_lines_stay_as_close_with_larger_text_and_edges_as_wide(ui: Ui) -> None:
    """A low window has room for few lines of it; of a denser screen, all grows, as the runner lets it."""
    style, told = imgui.get_style(), list[tuple[float, ...]]()
    for percent, density in ((100, 1.0), (200, 1.0), (200, 2.0)):
        theme.wear("dark", percent, density)
        told.append((style.item_spacing.y, style.frame_padding.y, style.docking_separator_size))
    assert told[1] == told[0]
    assert told[2] == tuple(2 * size for size in told[0])


@pytest.mark.parametrize("percent", [80, 100, 110, 150])
@pytest.mark.parametrize("density", [1.25, 1.5, 2.0])
def test_another_theme_has_the_gaps_that_the_runner_made_at_the_start(
    ui: Ui, percent: int, density: float
) -> None:
    style, told = imgui.get_style(), list[tuple[float, ...]]()
    theme.wear("dark", percent)
    style.scale_all_sizes(density)
    for _ in range(2):
        padding, spacing, inner = style.frame_padding, style.item_spacing, style.item_inner_spacing
        sizes = style.scrollbar_size, style.docking_separator_size, style.window_border_size
        told.append((*padding, *spacing, *inner, *sizes))
        theme.wear("light", percent, density)
    assert told[1] == told[0]


def test_theme_and_size_are_kept(state: AppState) -> None:
    actions.choose_theme(state, "light")
    for _ in range(3):
        actions.resize_text(state, 1)
    keep_all(state)
    kept = load_settings(state.places.settings_file)
    assert kept == state.settings == Settings(acknowledged=True, theme="light", text_percent=150)
    actions.choose_text_size(state, 100)
    keep_all(state)
    assert load_settings(state.places.settings_file).text_percent == 100
