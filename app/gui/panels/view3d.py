"""The 3D view: the reconstruction through a camera that the hand turns, at a time of the clip."""

from __future__ import annotations

import math

from imgui_bundle import ImVec2, ImVec4, imgui
from imgui_bundle import icons_fontawesome_4 as icons

from app.gui import actions, theme
from app.gui.legible import legible
from app.gui.orbit import Orbit
from app.gui.state import AppState
from app.gui.viewport import OnScreen, Viewport
from app.gui.widgets import button, centered, em, explain, stack_tags

TURN = 2.2
"""Radians for a drag across the whole view."""
WHEEL_STEP = 1.12
Tag = tuple[str, ImVec4]


def draw_view3d(state: AppState, viewport: Viewport) -> None:
    """The view with its controls."""
    if state.model is None:
        state.view_size = (0, 0)
        _draw_empty(state)
        return
    _draw_toolbar(state)
    space = imgui.get_content_region_avail()
    size = ImVec2(max(space.x, em(4)), max(space.y, em(4)))
    corner = imgui.get_cursor_screen_pos()
    buttons = imgui.ButtonFlags_
    imgui.invisible_button(
        "view", size, buttons.mouse_button_left | buttons.mouse_button_right | buttons.mouse_button_middle
    )
    _move(state, size)
    scale = imgui.get_io().display_framebuffer_scale
    state.view_size = (int(size.x * scale.x), int(size.y * scale.y))
    _draw_picture(state, viewport.show(state), corner, size)


def _draw_empty(state: AppState) -> None:
    imgui.dummy(ImVec2(0, max(imgui.get_content_region_avail().y / 2 - em(2), 0)))
    centered("The first preview of the reconstruction is on its way…")


def _draw_toolbar(state: AppState) -> None:
    button(f"{icons.ICON_FA_HOME}  Clip camera", lambda: actions.reset_view(state))
    explain("Home or a double click: the view of the clip's own camera.")
    imgui.same_line()
    if state.clip is None:
        _draw_time(state)
        return
    changed, _ = imgui.checkbox("Follow the clip's time", state.linked)
    explain("Off: the 3D view keeps a time of its own.")
    if changed:
        actions.toggle_link(state)
    if not state.linked:
        imgui.same_line()
        _draw_time(state)


def _draw_time(state: AppState) -> None:
    imgui.set_next_item_width(-em(0.1))
    changed, time = imgui.slider_float("##time", state.time, 0.0, 1.0, "time %.3f")
    if changed:
        actions.seek_view(state, time)


def _move(state: AppState, size: ImVec2) -> None:
    """Left drag turns, right or middle drag moves, the wheel goes nearer, a double click goes back."""
    io = imgui.get_io()
    across, down = io.mouse_delta.x / size.x, io.mouse_delta.y / size.x
    held = imgui.is_item_active() and not imgui.is_mouse_double_clicked(imgui.MouseButton_.left)
    state.view_dragged = held and any(imgui.is_mouse_down(index) for index in range(3))
    if held and (across or down):
        if imgui.is_mouse_down(imgui.MouseButton_.left):
            state.orbit = state.orbit.orbited(-TURN * across, TURN * down)
        else:
            field = 2 * math.tan(math.radians(30))
            state.orbit = state.orbit.panned(field * across, field * down)
    if imgui.is_item_hovered():
        imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
        if io.mouse_wheel:
            state.orbit = state.orbit.zoomed(WHEEL_STEP**io.mouse_wheel)
        if imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
            actions.reset_view(state)


def _draw_picture(state: AppState, shown: OnScreen | None, corner: ImVec2, size: ImVec2) -> None:
    end = ImVec2(corner.x + size.x, corner.y + size.y)
    draw = imgui.get_window_draw_list()
    draw.push_clip_rect(corner, end, True)
    draw.add_rect_filled(corner, end, imgui.get_color_u32(theme.grey(0.0)))
    if shown is not None:
        draw.add_image(shown.texture, corner, end, shown.uv0, shown.uv1)
    stack_tags(view_tags(state, shown), corner)
    draw.pop_clip_rect()


def view_tags(state: AppState, shown: OnScreen | None) -> list[Tag]:
    """What the view says of itself: what it is of, how new, how fine."""
    if shown is None:
        return [("DRAWING…", theme.TAG_CAUTION)]
    model = shown.request.shown
    tags: list[Tag] = []
    if model.live:
        count = f"{model.iteration} / {model.iterations}"
        tags.append((f"LIVE PREVIEW · iteration {count}", theme.TAG_CAUTION))
    is_file = model.iterations == 0
    said = f"SPLATS · {legible(model.name)}" if is_file else f"RECONSTRUCTION · time {shown.request.time:.3f}"
    tags.append((said, theme.TAG_ORIGINAL))
    if state.orbit != Orbit():
        tags.append(("FREE VIEW · not the endoscope's", theme.TAG_ORIGINAL))
    if shown.request.reduced:
        tags.append(("REDUCED RESOLUTION while moving", theme.TAG_CAUTION))
    return tags
