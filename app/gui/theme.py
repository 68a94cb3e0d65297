"""Colours, spacing and fonts. Greys have no hue: nothing tints how tissue is seen."""

from __future__ import annotations

from imgui_bundle import ImVec2, ImVec4, hello_imgui, imgui, implot

FONT_SIZE = 16.0


def grey(level: float, alpha: float = 1.0) -> ImVec4:
    return ImVec4(level, level, level, alpha)


SURROUND = grey(0.085)
"""Around pictures: dark and neutral."""
TEXT = grey(0.90)
MUTED = grey(0.62)
ACCENT = ImVec4(0.36, 0.60, 0.86, 1.0)
ACCENT_DIM = ImVec4(0.24, 0.41, 0.60, 1.0)
GRAB = ImVec4(0.29, 0.49, 0.71, 1.0)
WARNING = ImVec4(0.95, 0.72, 0.30, 1.0)
DANGER = ImVec4(0.93, 0.42, 0.38, 1.0)
TAG_ORIGINAL = ImVec4(0.20, 0.20, 0.20, 0.88)
TAG_ENHANCED = ImVec4(0.13, 0.36, 0.60, 0.94)
TAG_CAUTION = ImVec4(0.78, 0.49, 0.07, 0.96)


def load_fonts() -> None:
    """Roboto with icons, from imgui-bundle's own assets (Apache 2.0 and OFL)."""
    hello_imgui.load_font_ttf_with_font_awesome_icons("fonts/Roboto/Roboto-Regular.ttf", FONT_SIZE)


def apply_style() -> None:
    """Sizes are for one em of 16 pixels; the runner scales them with the screen's density."""
    style = imgui.get_style()
    style.window_padding = ImVec2(10, 10)
    style.frame_padding = ImVec2(8, 3)
    style.item_spacing = ImVec2(8, 5)
    style.item_inner_spacing = ImVec2(6, 4)
    style.scrollbar_size = 12
    style.grab_min_size = 11
    style.frame_rounding = style.grab_rounding = style.popup_rounding = 4
    style.child_rounding = style.scrollbar_rounding = 4
    style.window_rounding = 0
    style.tab_rounding = 3
    style.popup_border_size = 1
    style.window_border_size = style.frame_border_size = style.tab_border_size = 0
    style.docking_separator_size = 3
    style.window_menu_button_position = imgui.Dir.none
    style.disabled_alpha = 0.45
    for role, color in _colors().items():
        style.set_color_(role, color)


def _colors() -> dict[imgui.Col_, ImVec4]:
    return _surfaces() | _controls()


def _surfaces() -> dict[imgui.Col_, ImVec4]:
    c = imgui.Col_
    return {
        c.text: TEXT, c.text_disabled: MUTED,
        c.window_bg: grey(0.135), c.child_bg: grey(0, 0), c.popup_bg: grey(0.17, 0.98),
        c.border: grey(0.26), c.border_shadow: grey(0, 0),
        c.menu_bar_bg: grey(0.11), c.title_bg: grey(0.10), c.title_bg_active: grey(0.10),
        c.title_bg_collapsed: grey(0.10),
        c.tab: grey(0.10), c.tab_hovered: grey(0.24), c.tab_selected: grey(0.19),
        c.tab_selected_overline: ACCENT, c.tab_dimmed: grey(0.10), c.tab_dimmed_selected: grey(0.17),
        c.tab_dimmed_selected_overline: grey(0.30),
        c.docking_preview: ACCENT_DIM, c.docking_empty_bg: SURROUND,
        c.modal_window_dim_bg: grey(0, 0.55), c.nav_windowing_dim_bg: grey(0, 0.4),
        c.table_header_bg: grey(0.17), c.table_row_bg_alt: grey(1, 0.02),
        c.plot_lines: ACCENT, c.plot_histogram: ACCENT_DIM,
    }  # fmt: skip


def _controls() -> dict[imgui.Col_, ImVec4]:
    c = imgui.Col_
    return {
        c.frame_bg: grey(0.21), c.frame_bg_hovered: grey(0.26), c.frame_bg_active: grey(0.30),
        c.button: grey(0.25), c.button_hovered: grey(0.32), c.button_active: grey(0.38),
        c.header: grey(0.24), c.header_hovered: grey(0.29), c.header_active: grey(0.33),
        c.slider_grab: GRAB, c.slider_grab_active: ACCENT, c.check_mark: ACCENT,
        c.separator: grey(0.24), c.separator_hovered: grey(0.38), c.separator_active: ACCENT,
        c.resize_grip: grey(0.25), c.resize_grip_hovered: grey(0.35), c.resize_grip_active: ACCENT,
        c.scrollbar_bg: grey(0, 0), c.scrollbar_grab: grey(0.28), c.scrollbar_grab_hovered: grey(0.36),
        c.scrollbar_grab_active: grey(0.44),
        c.nav_cursor: ACCENT, c.drag_drop_target: ACCENT, c.text_selected_bg: ACCENT_DIM,
    }  # fmt: skip


def apply_plot_style() -> None:
    """Plots as flat as the panels they are in."""
    style = implot.get_style()
    style.set_color_(implot.Col_.frame_bg, grey(0, 0))
    style.set_color_(implot.Col_.plot_bg, grey(0.10))
    style.set_color_(implot.Col_.plot_border, grey(0.22))
    style.set_color_(implot.Col_.axis_grid, grey(1, 0.10))
    style.plot_padding = ImVec2(4, 4)
