"""The clip's time, below everything: its frames in small, play, step, scrub, trim and mask."""

from __future__ import annotations

from collections.abc import Callable

from imgui_bundle import ImVec2, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons

from app.enhancement.image_mask import NO_MASK
from app.gui.actions import actions, clip_actions, export_actions, laid_out
from app.gui.commands.commands import has_something
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.style.widgets import button, em, explain
from app.gui.work.strip import Strip, count_for
from renderer.clip import ByteImage

STRIP_HEIGHT = 2.5
EMPTY = "The frames of the open clip appear here."
TOOL_LABELS = {"text": "Text box", "view": "View circle"}


def draw_timeline(state: AppState, texture: Callable[[ByteImage], imgui.ImTextureRef]) -> None:
    """Two rows; greyed out without a clip."""
    count = 1 if state.source.clip is None else len(state.source.clip)
    _draw_strip(state, count, texture)
    imgui.begin_disabled(count < 2)
    _draw_transport(state)
    imgui.same_line()
    imgui.set_next_item_width(-em(24.5))
    label = "no clip" if state.source.clip is None else f"frame %d / {count}"
    flags = imgui.SliderFlags_.always_clamp
    grab = imgui.get_style().color_(imgui.Col_.slider_grab) if count > 1 else theme.grey(0, 0)
    with imgui_ctx.push_style_color(imgui.Col_.slider_grab, grab):
        changed, frame = imgui.slider_int(
            "##frame", state.timeline.frame_index + 1, 1, max(count, 2), label, flags
        )
    if changed:
        actions.seek(state, frame - 1)
    imgui.same_line()
    _draw_trim(state)
    imgui.end_disabled()
    imgui.same_line()
    _draw_mask(state)
    imgui.same_line()
    enabled = has_something(state)
    save = lambda: export_actions.save_picture(state)  # noqa: E731
    button(f"{icons.ICON_FA_CAMERA}  Save image", save, enabled=enabled, width=-1.0)
    explain("S: original, enhanced and 3D view side by side, with everything needed to reproduce them")


def _draw_transport(state: AppState) -> None:
    play = icons.ICON_FA_PAUSE if state.timeline.playing else icons.ICON_FA_PLAY
    button(f"{icons.ICON_FA_STEP_BACKWARD}##back", lambda: actions.step(state, -1), width=2.2)
    explain("Comma: previous frame")
    imgui.same_line(0, em(0.2))
    button(f"{play}###play", lambda: actions.toggle_play(state), width=3)
    explain("P or K: play or pause")
    imgui.same_line(0, em(0.2))
    button(f"{icons.ICON_FA_STEP_FORWARD}##on", lambda: actions.step(state, 1), width=2.2)
    explain("Period: next frame")


def _draw_trim(state: AppState) -> None:
    button("In", lambda: clip_actions.trim_here(state, start=True), width=2.2)
    explain("Shift+I: start the clip at this frame, for playback, statistics and reconstruction.")
    imgui.same_line(0, em(0.2))
    button("Out", lambda: clip_actions.trim_here(state, start=False), width=2.6)
    explain("Shift+O: end the clip at this frame.")
    imgui.same_line(0, em(0.2))
    trimmed = state.source.part.trim is not None
    button("All", lambda: clip_actions.untrim(state), enabled=trimmed, width=2.4)
    explain("Use the whole clip again.")


def _draw_mask(state: AppState) -> None:
    clip = state.source.clip is not None
    imgui.begin_disabled(not clip)
    said = TOOL_LABELS.get(state.picture.mask_tool, "Mask")
    color = theme.switch(bool(state.picture.mask_tool), caution=True)
    imgui.push_style_color(imgui.Col_.button, color)
    if imgui.button(f"{'Drag now' if state.picture.mask_tool else said}###mask", ImVec2(em(5), 0)):
        imgui.open_popup("mask")
    imgui.pop_style_color()
    explain(
        "Leave burned-in text and the surround out of statistics and reconstruction; saved with the clip."
    )
    imgui.end_disabled()
    if not imgui.begin_popup("mask"):
        return
    mask = state.source.part.mask
    for shape, label in TOOL_LABELS.items():
        drawn = getattr(mask, shape) is not None
        if imgui.menu_item_simple(f"{label}: draw", "", drawn, True):
            clip_actions.draw_mask(state, shape)
        explain("Then drag over the frame: from corner to corner, or from the centre to the rim.")
    if imgui.menu_item_simple("View circle: detect", "", False, state.picture.pictures is not None):
        clip_actions.round_view(state)
    if imgui.menu_item_simple("Clear", "", False, mask != NO_MASK):
        clip_actions.clear_mask(state)
    imgui.separator()
    if imgui.menu_item_simple("Tint tools and masked areas", "Shift+M", state.picture.overlay, True):
        clip_actions.toggle_overlay(state)
    imgui.end_popup()


def _draw_strip(state: AppState, count: int, texture: Callable[[ByteImage], imgui.ImTextureRef]) -> None:
    """The clip in small; a click or drag goes to that frame."""
    corner = imgui.get_cursor_screen_pos()
    size = ImVec2(max(imgui.get_content_region_avail().x, em(4)), em(STRIP_HEIGHT))
    clip = state.source.clip
    laid_out.size_strip(state, 0 if clip is None else count_for(clip, size.x, size.y))
    imgui.invisible_button("strip", size)
    if imgui.is_item_active() and state.source.clip is not None:
        actions.seek(state, int((imgui.get_io().mouse_pos.x - corner.x) / size.x * count))
    explain("Thumbnails of the clip: click or drag to go to a frame.")
    draw, end = imgui.get_window_draw_list(), ImVec2(corner.x + size.x, corner.y + size.y)
    if state.source.clip is None:
        _draw_empty(corner, size)
        return
    draw.add_rect_filled(corner, end, imgui.get_color_u32(theme.SURROUND))
    if state.timeline.strip is not None and state.timeline.strip.request.clip is state.source.clip:
        _draw_small(state.timeline.strip, texture(state.timeline.strip.image), corner, size)
    _draw_marks(state, count, corner, size)


def _draw_small(strip: Strip, shown: imgui.ImTextureRef, corner: ImVec2, size: ImVec2) -> None:
    """Each of the strip's frames where it is in the clip."""
    draw, edges = imgui.get_window_draw_list(), strip.edges(size.x, size.y)
    for place, (left, right) in enumerate(edges):
        ends = ImVec2(corner.x + left, corner.y), ImVec2(corner.x + right, corner.y + size.y)
        part = ImVec2(place / len(edges), 0), ImVec2((place + 1) / len(edges), 1)
        draw.add_image(shown, *ends, *part)


def _draw_empty(corner: ImVec2, size: ImVec2) -> None:
    """Where the frames will be."""
    draw, end = imgui.get_window_draw_list(), ImVec2(corner.x + size.x, corner.y + size.y)
    draw.add_rect(corner, end, imgui.get_color_u32(theme.now().shade(0.21)), em(0.25))
    said = imgui.calc_text_size(EMPTY)
    at = ImVec2(corner.x + (size.x - said.x) / 2, corner.y + (size.y - said.y) / 2)
    draw.add_text(at, imgui.get_color_u32(theme.now().muted), EMPTY)


def _draw_marks(state: AppState, count: int, corner: ImVec2, size: ImVec2) -> None:
    """The present frame, and what the trim leaves out in the dark."""
    draw, bottom = imgui.get_window_draw_list(), corner.y + size.y
    first, last = state.source.span
    edges = [corner.x + size.x * edge / count for edge in (0, first, last + 1, count)]
    for left, right in (edges[:2], edges[2:]):
        draw.add_rect_filled(
            ImVec2(left, corner.y), ImVec2(right, bottom), imgui.get_color_u32(theme.grey(0.05, 0.75))
        )
    if state.source.part.trim is not None:
        for x in edges[1:3]:
            ink = imgui.get_color_u32(theme.MARK)
            draw.add_line(ImVec2(x, corner.y), ImVec2(x, bottom), ink, em(0.15))
    left = corner.x + size.x * state.timeline.frame_index / count
    right = max(corner.x + size.x * (state.timeline.frame_index + 1) / count, left + em(0.2))
    ink = imgui.get_color_u32(theme.INK)
    draw.add_rect(ImVec2(left, corner.y), ImVec2(right, bottom), ink, 0, em(0.12))
