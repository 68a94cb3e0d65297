"""One pane over the whole window, with no more than what it is, on demand."""

from __future__ import annotations

from imgui_bundle import ImVec2, imgui, imgui_ctx

from app.gui.actions import laid_out, presenting
from app.gui.drawing.textures import ShowsPictures
from app.gui.drawing.viewport import Viewport
from app.gui.panels.editing import draw_edit_tools
from app.gui.panels.overlays import LONG_NOTICE
from app.gui.panels.picture_pane import draw_pane
from app.gui.panels.view3d import draw_alone
from app.gui.state.app_state import AppState
from app.gui.state.panes import pane
from app.gui.style import theme
from app.gui.style.labels import tag, tag_height
from app.gui.style.widgets import Area, em
from app.gui.views.comparison import Side

HINT = "Esc: leave   ·   1 2 3: panes   ·   L: labels"
FLAGS = (
    imgui.WindowFlags_.no_decoration | imgui.WindowFlags_.no_docking | imgui.WindowFlags_.no_saved_settings
    | imgui.WindowFlags_.no_move | imgui.WindowFlags_.no_bring_to_front_on_focus
    | imgui.WindowFlags_.no_scroll_with_mouse | imgui.WindowFlags_.no_background
)  # fmt: skip
HOST = "MainDockSpace"
"""The runner's window of all panels, which are hidden meanwhile."""


def draw_presentation(
    state: AppState, textures: ShowsPictures, backdrop: ShowsPictures, viewport: Viewport
) -> None:
    """Nothing unless something is presented. In its first frame the runner still draws grounds of the panels,
    over what lies behind them, and in its last one it does again."""
    name = state.presenting.pane or state.presenting.ending
    if name is None:
        return
    screen, style = imgui.get_main_viewport(), imgui.StyleVar_
    imgui.set_next_window_pos(screen.pos)
    imgui.set_next_window_size(screen.size)
    with (
        imgui_ctx.push_style_var(style.window_padding, ImVec2(0, 0)),
        imgui_ctx.push_style_var(style.window_border_size, 0.0),
        imgui_ctx.push_style_var(style.window_rounding, 0.0),
        imgui_ctx.begin("##presentation", None, FLAGS),
    ):
        _go_behind_dialogs()
        over = imgui.is_window_appearing() or state.presenting.ending is not None
        shows = textures if over else backdrop
        (area, below), labels = _divided(Area(screen.pos, screen.size)), presenting.has_labels(state)
        ground = imgui.get_color_u32(theme.SURROUND)
        imgui.get_window_draw_list().add_rect_filled(below.corner, below.end, ground)
        if name == "3D view":
            draw_alone(state, viewport, area, shows, labels=labels)
            draw_edit_tools(state)
        else:
            _draw_picture(state, shows, name, area, labels=labels)
        if labels:
            _draw_hint(state, below)


def _go_behind_dialogs() -> None:
    """Over the runner's own window only: what opens meanwhile, or is open, is in front."""
    host: imgui.internal.Window | None = imgui.internal.find_window_by_name(HOST)
    if imgui.is_window_appearing() and host is not None:
        imgui.internal.bring_window_to_display_back(host)


def _draw_picture(state: AppState, textures: ShowsPictures, side: Side, area: Area, *, labels: bool) -> None:
    if state.picture.pictures is None:
        return
    shown = pane(state, state.picture.pictures, side)
    laid_out.point(state, draw_pane(state, textures, side, shown, (shown,), area, labels=labels))


def _draw_hint(state: AppState, below: Area) -> None:
    """In the middle: the notice, and for the first moments how to leave."""
    line = f"{LONG_NOTICE}   ·   {HINT}" if state.window.now < state.presenting.labels_until else LONG_NOTICE
    room = min(imgui.calc_text_size(line).x + em(0.9), below.size.x - em(0.8)) + 1
    gap = (below.size - ImVec2(room, tag_height(line, room))) / 2
    tag(line, below.corner + gap, theme.TAG_ORIGINAL, room)


def _divided(screen: Area) -> tuple[Area, Area]:
    """The pane, and below it a strip for the hint, which lies on no image; it is there without one as well,
    so that the image stays where it is."""
    strip = tag_height(f"{LONG_NOTICE}   ·   {HINT}", screen.size.x - em(0.8)) + em(0.3)
    pane = Area(screen.corner, screen.size - ImVec2(0, strip))
    return pane, Area(screen.corner + ImVec2(0, pane.size.y), ImVec2(screen.size.x, strip))
