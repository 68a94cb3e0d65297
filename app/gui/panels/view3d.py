"""The 3D view: the reconstruction through a camera that the hand turns, at a time of the clip."""

from __future__ import annotations

import math
from functools import partial

from imgui_bundle import ImVec2, ImVec4, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons

from app.gui.actions import actions, camera_actions, laid_out, presenting
from app.gui.commands.camera_commands import second_commands
from app.gui.drawing.textures import ShowsPictures
from app.gui.drawing.viewport import OnScreen, Viewport
from app.gui.panels.menus import draw_commands
from app.gui.panels.overlays import make_room
from app.gui.panels.scene_marks import Sight, draw_color_bar, draw_marks, is_on_first
from app.gui.state.app_state import AppState
from app.gui.state.panes import frame_share
from app.gui.state.run_words import doing
from app.gui.state.tags import cautions
from app.gui.state.view_words import frame_over, view_tags
from app.gui.style import theme
from app.gui.style.handles import slide_labelled
from app.gui.style.labels import stack_tags
from app.gui.style.widgets import (
    Area,
    beside,
    beside_of,
    button,
    centered,
    checkbox,
    choose,
    dragged,
    em,
    explain,
    toggle,
)
from app.scenes.backgrounds import Background
from app.scenes.view_kinds import EXPLAINED
from app.scenes.view_request import ViewRequest
from renderer.unobserved import GREY

TURN = 2.2
"""Radians for a drag across the whole view."""
WHEEL_STEP = 1.12
SPEED_STEP = 1.25
CLICK = 4.0
"""Pixels that a hand may slip in a click."""
VIEW_BUTTONS = (
    imgui.ButtonFlags_.mouse_button_left | imgui.ButtonFlags_.mouse_button_right
    | imgui.ButtonFlags_.mouse_button_middle
)  # fmt: skip
FLY = f"{icons.ICON_FA_PAPER_PLANE}  Fly###fly"
MEASURE = f"{icons.ICON_FA_CROSSHAIRS}  Measure###measure"
SECOND = f"{icons.ICON_FA_COLUMNS}###second"
FRAME = f"{icons.ICON_FA_CLONE}  Frame###snap"
FLY_TEXT = "G: fly with W, S, A, D, Q and E; drag to look around, wheel for speed. Shift+C: back."
MEASURE_TEXT = (
    "M: click two points on the surface; Shift+click goes on to a third and further ones, on the first it "
    "closes the line: the flat area inside. Measured on the model, at its expected depth; ± is one standard "
    "deviation, from the spread of the surface there and the error of the run's depths."
)
SECOND_TEXT = (
    "A second reconstruction beside this one, with the same camera and time. Also in the Camera menu."
)
FRAME_TEXT = (
    "C: align with the clip's camera, with its frame over the reconstruction. Moving the view ends this."
)


def draw_view3d(state: AppState, viewport: Viewport, second: Viewport, textures: ShowsPictures) -> None:
    """The view with its controls, beside it the second reconstruction when there is one.

    The first view is the last item drawn, for those who draw on it.
    """
    if state.scene.model is None:
        laid_out.size_view(state, 0, 0)
        imgui.dummy(ImVec2(0, max(imgui.get_content_region_avail().y / 2 - em(2), 0)))
        centered("Waiting for the first preview of the reconstruction…")
        centered(doing(state))
        return
    make_room(state)
    _draw_toolbar(state)
    space, gap = imgui.get_content_region_avail(), em(0.3)
    corner, count = imgui.get_cursor_screen_pos(), 1 if state.scene.second.model is None else 2
    size = ImVec2(max((space.x + gap) / count - gap, em(4)), max(space.y, em(4)))
    scale = imgui.get_io().display_framebuffer_scale
    laid_out.size_view(state, int(size.x * scale.x), int(size.y * scale.y))
    if state.scene.second.model is not None:
        right = Area(corner + ImVec2(size.x + gap, 0), size)
        _draw_pane(state, "second view", second, state.second_request, right, textures)
    _draw_pane(state, "view", viewport, state.plain_view_request, Area(corner, size), textures)


def draw_alone(
    state: AppState, viewport: Viewport, area: Area, textures: ShowsPictures, *, labels: bool
) -> None:
    """The view and nothing else, over all of the area; without `labels` it says only what could mislead."""
    scale = imgui.get_io().display_framebuffer_scale
    laid_out.size_view(state, int(area.size.x * scale.x), int(area.size.y * scale.y))
    _draw_pane(state, "view", viewport, state.plain_view_request, area, textures, labels=labels)


def _draw_pane(
    state: AppState,
    name: str,
    viewport: Viewport,
    seen: ViewRequest | None,
    area: Area,
    textures: ShowsPictures,
    *,
    labels: bool = True,
) -> None:
    """One of the views; the hand on either moves both."""
    imgui.set_cursor_screen_pos(area.corner)
    imgui.invisible_button(name, area.size, VIEW_BUTTONS)
    presenting.draw(state, "3D view")
    if imgui.is_item_hovered():
        presenting.point(state, "3D view", clicked=imgui.is_item_clicked())
    _move(state, area)
    if seen is not None:
        _pick(state, seen, area)
    with imgui_ctx.push_clip_rect(area.corner, area.end, True):
        shown = viewport.show(state)
        _draw_picture(state, shown, textures, area)
        tags = view_tags(state, None if shown is None else shown.request)
        stack_tags(tags if labels else cautions(tags), area.corner, area.size.x)


def _draw_toolbar(state: AppState) -> None:
    viewer = state.scene.viewer
    reset = partial(camera_actions.reset_view, state)
    button(f"{icons.ICON_FA_HOME}  Clip camera", reset, "Shift+C: the clip camera's view.")
    beside(FLY)
    toggle(FLY, lambda: camera_actions.toggle_flight(state), FLY_TEXT, on=viewer.flying)
    beside(MEASURE)
    toggle(MEASURE, partial(camera_actions.toggle_measuring, state), MEASURE_TEXT, on=viewer.measuring)
    beside(SECOND)
    _draw_second(state)
    _draw_snap(state)
    _draw_kind(state)
    if state.source.clip is None or state.shows_other_clip:
        _draw_time(state)
        return
    beside_of(em(12))
    changed, _ = checkbox("Follow the clip's time", state.scene.linked)
    explain("Off: the 3D view has its own time.")
    if changed:
        actions.toggle_link(state)
    if not state.scene.linked:
        _draw_time(state)


def _draw_second(state: AppState) -> None:
    shown = state.scene.second.model is not None
    toggle(SECOND, lambda: imgui.open_popup("second"), SECOND_TEXT, on=shown)
    beside(FRAME)
    with imgui_ctx.begin_popup("second") as popup:
        if popup:
            draw_commands(state, second_commands(state))


def _draw_snap(state: AppState) -> None:
    snapped = state.scene.viewer.snapped
    snap = partial(camera_actions.toggle_snap, state)
    toggle(FRAME, snap, FRAME_TEXT, on=snapped, enabled=state.has_frames)
    if not snapped:
        return
    beside_of(em(8))
    imgui.set_next_item_width(em(8))
    share, form, flags = 100 * state.scene.viewer.blend, "frame %.0f %%", imgui.SliderFlags_.always_clamp
    changed, percent = slide_labelled("##blend", share, 0, 100, form, flags)
    explain("[ and ]: from the reconstruction alone (0) to the frame alone (100).")
    if changed:
        camera_actions.blend(state, percent / 100)


def _draw_kind(state: AppState) -> None:
    kinds = {kind: kind.capitalize().replace("Color", "Colour") for kind in camera_actions.choices(state)}
    beside_of(em(7.2))
    now = state.scene.kind if state.scene.kind in kinds else "color"
    chosen = choose("kind", now, kinds, f"N: next view. {EXPLAINED[now]}", 7.2)
    if chosen != now:
        camera_actions.choose_view(state, chosen)


def _draw_time(state: AppState) -> None:
    model = state.scene.model
    if model is None or len(model.cameras) < 2 or model.is_series:
        return  # Between the moments of a series there is nothing: the timeline has them all.
    beside_of(em(8))
    imgui.set_next_item_width(-em(0.1))
    first, last = model.start + 1, model.start + len(model.cameras)
    number, form = model.number_at(state.time), f"frame {model.form(state.time)}"
    # Also to moments between frames.
    flags = imgui.SliderFlags_.no_round_to_format
    changed, number = slide_labelled("##time", number, first, last, form, flags)
    explain(f"The moment that is shown, also between frames: time {state.time:.3f} (0 to 1).")
    if changed:
        actions.seek_view(state, model.time_of(number))


def _move(state: AppState, area: Area) -> None:
    """Left drag turns, right or middle drag moves, the wheel goes nearer, or sets the speed of flight."""
    io, left, across = imgui.get_io(), imgui.is_mouse_down(imgui.MouseButton_.left), area.size.x
    held = imgui.is_item_active() and not imgui.is_mouse_double_clicked(imgui.MouseButton_.left)
    held = held and not (state.editing.takes_drags and not io.key_alt and left)
    if held and any(imgui.is_mouse_down(index) for index in range(3)):
        laid_out.drag_view(state)
    by = dragged()
    if held and (by.x or by.y):
        if left:
            camera_actions.turn(state, -TURN * by.x / across, TURN * by.y / across)
        else:
            zoom = Sight(state.scene.model.cameras[0], area).place.zoom if state.scene.model else 1.0
            camera_actions.pan(state, by.x / zoom, by.y / zoom)
    if imgui.is_item_hovered():
        imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
        if io.mouse_wheel:
            step = SPEED_STEP if state.scene.viewer.flying else WHEEL_STEP
            camera_actions.zoom(state, step**io.mouse_wheel)


def _pick(state: AppState, request: ViewRequest, area: Area) -> None:
    """A double click, or U, turns the view around what is under the pointer; a click may measure."""
    if not imgui.is_item_hovered() or state.editing.takes_drags:
        return
    pixel = Sight(request.camera, area).pixel()
    left, measuring = imgui.MouseButton_.left, state.scene.viewer.measuring
    wants_centre = imgui.is_key_pressed(imgui.Key.u, False) and not imgui.get_io().want_text_input
    if wants_centre or (imgui.is_mouse_double_clicked(left) and not measuring):
        camera_actions.ask_point(state, request, pixel, "orbit")
    moved = imgui.get_mouse_drag_delta(left, 0.0)
    if measuring and imgui.is_mouse_released(left) and math.hypot(moved.x, moved.y) < CLICK:
        _measure(state, request, area)


def _measure(state: AppState, request: ViewRequest, area: Area) -> None:
    goes_on = imgui.get_io().key_shift
    if goes_on and is_on_first(state, request, area):
        camera_actions.close_outline(state)
    else:
        pixel = Sight(request.camera, area).pixel()
        camera_actions.ask_point(state, request, pixel, "measure on" if goes_on else "measure")


def _draw_picture(state: AppState, shown: OnScreen | None, textures: ShowsPictures, area: Area) -> None:
    draw = imgui.get_window_draw_list()
    draw.add_rect_filled(area.corner, area.end, imgui.get_color_u32(ground(state.background)))
    if shown is not None:
        low, high = Sight(shown.request.camera, area).bounds
        draw.add_image(shown.texture, low, high, shown.uv0, shown.uv1)
        if (frame_image := frame_over(state, shown.request)) is not None:
            tint = imgui.get_color_u32(theme.grey(1.0, frame_share(state, shown.request.scene)))
            over = textures.whole("frame over view", frame_image.image)
            draw.add_image(over, low, high, (0, 0), (1, 1), tint)
        draw_marks(state, shown.request, area)
        if shown.scale is not None:
            draw_color_bar(shown.scale, area)


def ground(background: Background) -> ImVec4:
    """What a pane is filled with until its picture is there, and beside it: as where nothing was observed."""
    red, green, blue = GREY if isinstance(background, str) else background
    return ImVec4(red, green, blue, 1.0)
