"""Colours of the dark and the light theme, spacing and fonts. Greys have no hue: nothing tints tissue."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from imgui_bundle import ImVec2, ImVec4, imgui, implot

from app.gui.state.tags import Tone
from app.gui.work.settings import Theme
from app.report.colors import COLORS

FONT_SIZE = 16.0
WHOLE = float(np.finfo(np.float32).max)
"""What ImGui takes for no shrinking: titles of panels stay whole, and tabs scroll where there is no room."""


def grey(level: float, alpha: float = 1.0) -> ImVec4:
    return ImVec4(level, level, level, alpha)


def packed(red: int, green: int, blue: int) -> int:
    """As draw lists take a colour, 0 to 255 each."""
    return imgui.get_color_u32(ImVec4(red / 255, green / 255, blue / 255, 1.0))


GROUND, LIGHT_GROUND = 0.135, 0.922
"""Grey of panels in the dark and in the light theme."""
FLARE = 0.05
"""Luminance of a screen's black as WCAG 2.2 counts it: contrast is the ratio of what is added to it."""


def _luminance(level: float) -> float:
    """Of a grey of sRGB, both in [0, 1]; IEC 61966-2-1."""
    return float(level / 12.92 if level <= 0.04045 else ((level + 0.055) / 1.055) ** 2.4)


def _mirrored(level: float) -> float:
    """As far from the light ground, in contrast, as `level` is from the dark one; at most white."""
    grounds = (_luminance(GROUND) + FLARE) * (_luminance(LIGHT_GROUND) + FLARE)
    luminance = min(max(grounds / (_luminance(level) + FLARE) - FLARE, 0.0), 1.0)
    return luminance * 12.92 if luminance <= 0.0031308 else 1.055 * luminance ** (1 / 2.4) - 0.055


@dataclass(frozen=True)
class Colors:
    """Of one theme."""

    mirrored: bool
    """Greys are turned round: light where the dark theme is dark."""
    text: ImVec4
    muted: ImVec4
    accent: ImVec4
    lit: ImVec4
    """A button that is on."""
    caution: ImVec4
    """A button that is on and should be noticed."""
    recording: ImVec4
    """A button that ends what it has begun."""
    grab: ImVec4
    thumb: ImVec4
    """Of scrollbars."""
    warning: ImVec4
    danger: ImVec4
    alarm: ImVec4
    """Behind an error."""

    def shade(self, level: float, alpha: float = 1.0) -> ImVec4:
        """The grey that plays the part of `level`, in [0, 1], in the dark theme: one of the same contrast to
        the ground of panels, on the other side of it."""
        return grey(_mirrored(level) if self.mirrored else level, alpha)

    @property
    def ground(self) -> ImVec4:
        """Of panels."""
        return self.shade(GROUND)

    @property
    def edge(self) -> ImVec4:
        """Of controls without words."""
        return self.shade(0.45)

    def veil(self, alpha: float) -> ImVec4:
        """A little of the text's colour over whatever is below."""
        return grey(0.0 if self.mirrored else 1.0, alpha)


DARK = Colors(
    mirrored=False,
    text=grey(0.90),
    muted=grey(0.70),
    accent=ImVec4(0.40, 0.65, 0.92, 1.0),
    lit=ImVec4(0.23, 0.40, 0.59, 1.0),
    caution=ImVec4(0.57, 0.34, 0.03, 1.0),
    recording=ImVec4(0.62, 0.16, 0.14, 1.0),
    grab=ImVec4(0.31, 0.51, 0.73, 1.0),
    thumb=grey(0.43),
    warning=ImVec4(0.95, 0.72, 0.30, 1.0),
    danger=ImVec4(0.97, 0.50, 0.46, 1.0),
    alarm=ImVec4(0.30, 0.13, 0.12, 0.98),
)
LIGHT = Colors(
    mirrored=True,
    text=grey(0.10),
    muted=grey(0.28),
    accent=ImVec4(0.09, 0.32, 0.60, 1.0),
    lit=ImVec4(0.40, 0.60, 0.85, 1.0),
    caution=ImVec4(0.82, 0.52, 0.08, 1.0),
    recording=ImVec4(0.95, 0.50, 0.46, 1.0),
    grab=ImVec4(0.24, 0.44, 0.68, 1.0),
    thumb=grey(0.52),
    warning=ImVec4(0.50, 0.29, 0.00, 1.0),
    danger=ImVec4(0.66, 0.11, 0.09, 1.0),
    alarm=ImVec4(0.99, 0.86, 0.84, 0.98),
)
THEMES: dict[Theme, Colors] = {"dark": DARK, "light": LIGHT}

SURROUND = grey(0.085)
"""Around pictures, and with them the same in both themes: dark and neutral. So are all marks on pictures."""
INK = grey(0.97)
CLEAR = grey(0, 0)
MARK = ImVec4(0.95, 0.72, 0.30, 1.0)
PATH = ImVec4(0.35, 0.80, 0.95, 1.0)
TAG_ORIGINAL = ImVec4(0.20, 0.20, 0.20, 0.88)
TAG_ENHANCED = ImVec4(0.13, 0.36, 0.60, 0.94)
TAG_CAUTION = ImVec4(0.58, 0.35, 0.03, 0.96)
TONES: dict[Tone, ImVec4] = {"plain": TAG_ORIGINAL, "enhanced": TAG_ENHANCED, "caution": TAG_CAUTION}
PLOT = (
    implot.Flags_.no_title | implot.Flags_.no_menus | implot.Flags_.no_box_select
    | implot.Flags_.no_mouse_text
)  # fmt: skip
"""Tooltips say what a point is; the pointer's own numbers would round small errors to 0."""
QUIET_PLOT = PLOT | implot.Flags_.no_legend


def now() -> Colors:
    """Those of the theme that the window wears."""
    return LIGHT if imgui.get_style().color_(imgui.Col_.window_bg).x > 0.5 else DARK


def switched_on(*, caution: bool) -> ImVec4:
    """A button's colour that says that something is on; `caution`: and that it should be noticed."""
    return now().caution if caution else now().lit


def touched(color: ImVec4, share: float) -> ImVec4:
    """A coloured button below the pointer: further from its words' colour, which stay as legible."""
    far = 1.0 if now().mirrored else 0.0
    red, green, blue = (value + share * (far - value) for value in (color.x, color.y, color.z))
    return ImVec4(red, green, blue, color.w)


def wear(theme: Theme, text_percent: int, density: float = 1.0) -> None:
    """Give window and plots this theme and size of text; between two frames. `density`: of the screen."""
    colors, style, plots = THEMES[theme], imgui.get_style(), implot.get_style()
    style.font_scale_main = text_percent / 100
    apply_style(text_percent / 100, density)
    for role, color in _roles(colors).items():
        style.set_color_(role, color)
    for part, color in _plots(colors).items():
        plots.set_color_(part, color)
    plots.plot_padding = ImVec2(4, 4)
    plots.colormap = _lines(colors)


def apply_style(text: float = 1.0, density: float = 1.0) -> None:
    """Sizes are for one em of 16 pixels, on a screen of that density. Larger text has wider gaps between
    words, in proportion; lines, for which a window has little room then, stay as close."""
    scale = density * text

    def wide(size: float) -> int:
        """Cut as the runner cuts what it scales."""
        return int(density * round(text * size))

    def gap(x: float, y: float) -> ImVec2:
        return ImVec2(wide(x), int(density * y))

    style = imgui.get_style()
    style.window_padding = gap(10, 10)
    # Also of panes beside and above each other.
    style.window_min_size = ImVec2(wide(220), wide(80))
    style.frame_padding = gap(8, 3)
    style.item_spacing = gap(8, 5)
    style.item_inner_spacing = gap(6, 4)
    style.scrollbar_size = wide(12)
    style.grab_min_size = wide(11)
    style.frame_rounding = style.grab_rounding = style.popup_rounding = 4 * scale
    style.child_rounding = style.scrollbar_rounding = 4 * scale
    style.window_rounding = 0
    style.tab_rounding = 3 * scale
    style.tab_min_width_shrink = WHOLE
    style.popup_border_size = style.window_border_size = int(density)
    style.frame_border_size = style.tab_border_size = 0
    style.docking_separator_size = int(3 * density)
    style.window_menu_button_position = imgui.Dir.none
    style.disabled_alpha = 0.45


def show_ground_of_panels(*, shown: bool) -> None:
    """Behind them; where it is covered it need not be painted: without a GPU, a layer takes milliseconds."""
    style, which = imgui.get_style(), imgui.Col_.docking_empty_bg
    color = style.color_(which)
    style.set_color_(which, ImVec4(color.x, color.y, color.z, float(shown)))


def _lines(colors: Colors) -> int:
    """ImPlot's number of the colours of lines, which it keeps by name; ink in place of black."""
    name = f"lines on {'light' if colors.mirrored else 'dark'}"
    known = int(implot.get_colormap_index(name))
    if known >= 0:
        return known
    parts = [[int(color[at : at + 2], 16) / 255 for at in (1, 3, 5)] for color in COLORS[:-1]]
    ink = colors.text
    table = np.array([*parts, [ink.x, ink.y, ink.z]], np.float32)
    return int(implot.add_colormap(name, np.column_stack([table, np.ones(len(table), np.float32)])))


def _roles(colors: Colors) -> dict[imgui.Col_, ImVec4]:
    c, shade = imgui.Col_, colors.shade
    return {
        c.text: colors.text, c.text_disabled: colors.muted,
        c.window_bg: colors.ground, c.child_bg: grey(0, 0), c.popup_bg: shade(0.17),
        c.border: shade(0.34), c.border_shadow: grey(0, 0),
        c.menu_bar_bg: shade(0.11), c.title_bg: shade(0.10), c.title_bg_active: shade(0.10),
        c.title_bg_collapsed: shade(0.10),
        c.tab: shade(0.10), c.tab_hovered: shade(0.24), c.tab_selected: shade(0.19),
        c.tab_selected_overline: colors.accent, c.tab_dimmed: shade(0.10), c.tab_dimmed_selected: shade(0.17),
        c.tab_dimmed_selected_overline: shade(0.30),
        c.docking_preview: colors.lit, c.docking_empty_bg: SURROUND,
        c.modal_window_dim_bg: grey(0, 0.55), c.nav_windowing_dim_bg: grey(0, 0.4),
        c.table_header_bg: shade(0.17), c.table_row_bg_alt: colors.veil(0.03),
        c.table_border_strong: shade(0.30), c.table_border_light: shade(0.24), c.table_row_bg: grey(0, 0),
        c.tree_lines: shade(0.30), c.unsaved_marker: colors.warning,
        c.plot_lines: colors.accent, c.plot_histogram: colors.lit,
        c.plot_lines_hovered: colors.warning, c.plot_histogram_hovered: colors.warning,
        c.frame_bg: shade(0.21), c.frame_bg_hovered: shade(0.26), c.frame_bg_active: shade(0.30),
        c.button: shade(0.25), c.button_hovered: shade(0.32), c.button_active: shade(0.38),
        c.header: shade(0.24), c.header_hovered: shade(0.26), c.header_active: shade(0.27),
        c.slider_grab: colors.grab, c.slider_grab_active: colors.grab, c.check_mark: colors.accent,
        c.checkbox_selected_bg: shade(0.21),
        c.separator: shade(0.24), c.separator_hovered: shade(0.38), c.separator_active: colors.accent,
        c.resize_grip: shade(0.25), c.resize_grip_hovered: shade(0.35), c.resize_grip_active: colors.accent,
        c.scrollbar_bg: grey(0, 0), c.scrollbar_grab: colors.thumb, c.scrollbar_grab_hovered: colors.muted,
        c.scrollbar_grab_active: colors.muted,
        c.nav_cursor: colors.accent, c.drag_drop_target: colors.accent, c.text_selected_bg: colors.lit,
        c.drag_drop_target_bg: grey(0, 0), c.input_text_cursor: colors.text,
        c.nav_windowing_highlight: colors.accent, c.text_link: colors.accent,
    }  # fmt: skip


def _plots(colors: Colors) -> dict[implot.Col_, ImVec4]:
    """As flat as the panels they are in."""
    c = implot.Col_
    return {
        c.frame_bg: grey(0, 0), c.plot_bg: colors.shade(0.10),
        c.plot_border: colors.shade(0.22), c.axis_grid: colors.veil(0.10),
    }  # fmt: skip
