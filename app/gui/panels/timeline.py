"""The clip's time, below everything: its frames in small, play, step, scrub, trim and mask."""

from __future__ import annotations

from functools import partial

from imgui_bundle import ImVec2, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons

from app.enhancement.image_mask import NO_MASK
from app.gui.actions import actions, clip_actions, export_actions, laid_out, masking_actions
from app.gui.commands.commands import has_something
from app.gui.drawing.textures import ShowsPictures
from app.gui.panels.live import draw_live_bar
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.style.handles import handle
from app.gui.style.widgets import TALL, Area, button, em, explain, percent, tall, text_within, toggle
from app.gui.views.clip_time import clock, seconds_at
from app.gui.views.frame_scale import PADDING, FrameScale
from app.gui.views.key_words import with_keys
from app.gui.work.strip import Strip, count_for

LEFT, RIGHT = 7.8, 9.0
"""Em that the buttons beside the strip and the slider have."""
SLOW = 0.9
"""Pace of playing below which it is said."""
EMPTY = "The frames of the open clip appear here."
SAVE_TEXT = "S: original, enhanced and 3D view side by side, with everything needed to reproduce them"
IN_TEXT = "Shift+I: start the clip at this frame, for playback, statistics and reconstruction."
MASK_TEXT = "Leave burned-in text and the surround out of statistics and reconstruction; saved with the clip."
TOOL_LABELS = {"text": "Text box", "view": "View circle"}


def draw_timeline(state: AppState, textures: ShowsPictures) -> None:
    """Two rows, the strip and the slider one above the other; greyed out without a clip. A live source has
    its own."""
    if state.live.session is not None and state.live.clip is not None:
        draw_live_bar(state)
        return
    count = max(state.moments, 1)
    room, start, gap = imgui.get_content_region_avail().x, imgui.get_cursor_pos_x(), em(0.5)
    left = round(start + em(LEFT) + gap)
    across = round(max(room - em(LEFT + RIGHT) - 2 * gap, em(4)))
    right = left + across + round(gap)
    imgui.begin_disabled(count < 2 and state.source.place is None)
    with imgui_ctx.push_style_var(imgui.StyleVar_.frame_padding, tall()):
        _draw_transport(state)
    imgui.end_disabled()
    imgui.same_line(left)
    _draw_strip(state, count, across, textures)
    imgui.same_line(right)
    with imgui_ctx.push_style_var(imgui.StyleVar_.frame_padding, tall()):
        save, enabled = partial(export_actions.save_picture, state), has_something(state)
        button(f"{icons.ICON_FA_CAMERA}  Save image", save, SAVE_TEXT, enabled=enabled, width=RIGHT)
    imgui.begin_disabled(count < 2 or state.source.clip is None)
    _draw_trim(state)
    imgui.end_disabled()
    imgui.same_line(left)
    imgui.begin_disabled(count < 2)
    _draw_slider(state, count, across)
    imgui.end_disabled()
    imgui.same_line(right)
    _draw_mask(state)


def _draw_slider(state: AppState, count: int, across: int) -> None:
    imgui.set_next_item_width(across)
    now, most, flags = state.moment + 1, max(count, 2), imgui.SliderFlags_.always_clamp
    label = in_folder(state) or place(state)
    if imgui.calc_text_size(_said(label, now)).x > across:
        label = label.split(" · ")[0]
    said = _said(label, now)
    scale = FrameScale(0, across, count, imgui.get_style().grab_min_size)
    # None where there is one frame.
    grab = handle(said, scale.ends(now - 1, now - 1), across) if count > 1 else theme.CLEAR
    color = imgui.Col_
    with (
        imgui_ctx.push_style_color(color.slider_grab, grab),
        imgui_ctx.push_style_color(color.slider_grab_active, grab),
    ):
        changed, frame = imgui.slider_int("##frame", now, 1, most, label, flags)
    if changed:
        actions.seek(state, frame - 1)


def _said(label: str, frame: int) -> str:
    return label.replace("%d", str(frame)).replace("%%", "%")


def in_folder(state: AppState) -> str:
    """Which of its folder's images a single one is; empty where there is none beside it."""
    place = state.source.place
    return "" if place is None else f"{place + 1} of {len(state.source.neighbours.images)} in this folder"


def place(state: AppState) -> str:
    """The number of the frame, for the slider to fill in, and of a video its time."""
    clip = state.source.clip
    if state.moments < 2 and clip is None:
        return "no clip"
    if state.is_model_alone and state.scene.model is not None and state.scene.model.start:
        # As its clip numbers them, of which the model is a part.
        return f"frame {state.moment + state.scene.model.start + 1} · %d / {state.moments}"
    seconds = None if clip is None else seconds_at(clip, state.moment)
    slow = f" · {percent(state.timeline.pace)}% of its speed" if state.timeline.pace < SLOW else ""
    return f"frame %d / {state.moments}" + ("" if seconds is None else f" · {clock(seconds)}") + slow


def _draw_transport(state: AppState) -> None:
    play = icons.ICON_FA_PAUSE if state.timeline.playing else icons.ICON_FA_PLAY
    step, alone = partial(actions.step, state), state.source.place is not None
    one = "image of this folder" if alone else "frame"
    button(
        f"{icons.ICON_FA_STEP_BACKWARD}##back",
        partial(step, -1),
        f"Left or Comma: previous {one}. With Shift: ten back. Home: first.",
        width=2.2,
    )
    imgui.same_line(0, em(0.2))
    toggle = partial(actions.toggle_play, state)
    button(f"{play}###play", toggle, "Space: play or pause", enabled=not alone, width=3)
    imgui.same_line(0, em(0.2))
    button(
        f"{icons.ICON_FA_STEP_FORWARD}##on",
        partial(step, 1),
        f"Right or Period: next {one}. With Shift: ten forward. End: last.",
        width=2.2,
    )


def _draw_trim(state: AppState) -> None:
    trim = partial(clip_actions.trim_here, state)
    button("In", partial(trim, start=True), IN_TEXT, width=2.4)
    imgui.same_line(0, em(0.2))
    button("Out", partial(trim, start=False), "Shift+O: end the clip at this frame.", width=2.6)
    imgui.same_line(0, em(0.2))
    everything, trimmed = partial(clip_actions.untrim, state), state.source.part.trim is not None
    button("All", everything, "Use the whole clip again.", enabled=trimmed, width=2.4)


def _draw_mask(state: AppState) -> None:
    tool, mask = state.picture.mask_tool, state.source.part.mask
    label, opens = f"{'Drag now' if tool else 'Mask'}###mask", partial(imgui.open_popup, "mask")
    enabled = state.source.clip is not None
    toggle(label, opens, MASK_TEXT, on=bool(tool), caution=True, enabled=enabled, width=RIGHT)
    with imgui_ctx.begin_popup("mask") as popup:
        if not popup:
            return
        for shape, name in TOOL_LABELS.items():
            if imgui.menu_item_simple(f"{name}: draw", "", getattr(mask, shape) is not None, True):
                clip_actions.draw_mask(state, shape)
            explain("Then drag over the frame: from corner to corner, or from the centre to the rim.")
        if imgui.menu_item_simple("View circle: detect", "", False, state.picture.pictures is not None):
            clip_actions.round_view(state)
        if imgui.menu_item_simple("Clear", "", False, mask != NO_MASK):
            clip_actions.clear_mask(state)
        imgui.separator()
        reason = clip_actions.why_no_clip(state)
        if imgui.menu_item_simple(
            "Tools: mask by hand…", with_keys("Ctrl+Shift+M"), state.masking.active, not reason
        ):
            masking_actions.toggle(state)
        explain(reason or "Mask surgical tools with a brush; other frames are learned from a few.")
        imgui.separator()
        if imgui.menu_item_simple("Tint masked areas", "Shift+M", state.picture.overlay, True):
            clip_actions.toggle_overlay(state)


def _draw_strip(state: AppState, count: int, across: int, textures: ShowsPictures) -> None:
    """The clip in small; a click or drag goes to that frame."""
    clip, strip = state.source.clip, state.timeline.strip
    area = Area.here(ImVec2(across, em(TALL)))
    scale = FrameScale(area.corner.x, across, count, imgui.get_style().grab_min_size)
    laid_out.size_strip(state, 0 if clip is None else count_for(clip, *area.inside))
    imgui.invisible_button("strip", area.size)
    if imgui.is_item_active() and count > 1:
        actions.seek(state, scale.frame_at(imgui.get_mouse_pos().x))
    explain("Thumbnails of the clip: click or drag to go to a frame." if count > 1 else "")
    draw = imgui.get_window_draw_list()
    if clip is None and count < 2:
        draw.add_rect(area.corner, area.end, imgui.get_color_u32(theme.now().shade(0.21)), em(0.25))
        text_within(area, EMPTY, theme.now().muted)
        return
    draw.add_rect_filled(area.corner, area.end, imgui.get_color_u32(theme.SURROUND))
    if strip is not None and clip is not None and strip.request.clip is clip:
        _draw_small(strip, textures.whole("strip", strip.image), area)
    _draw_marks(state, scale, area)
    if state.opens:
        _draw_leaving(state.opens, area)


def _draw_leaving(text: str, area: Area) -> None:
    """The thumbnails in the dark, behind what takes their place."""
    dark = imgui.get_color_u32(theme.grey(0.05, 0.75))
    imgui.get_window_draw_list().add_rect_filled(area.corner, area.end, dark)
    text_within(area, text, theme.INK)


def _draw_small(strip: Strip, shown: imgui.ImTextureRef, area: Area) -> None:
    """Each of the strip's frames where it is in the clip."""
    draw, edges = imgui.get_window_draw_list(), strip.edges(area.size.x - 2 * PADDING, area.size.y)
    corner = area.corner + ImVec2(PADDING, 0)
    for place, (left, right) in enumerate(edges):
        ends = corner + ImVec2(left, 0), corner + ImVec2(right, area.size.y)
        part = ImVec2(place / len(edges), 0), ImVec2((place + 1) / len(edges), 1)
        draw.add_image(shown, *ends, *part)


def _draw_marks(state: AppState, scale: FrameScale, area: Area) -> None:
    """The present frame, above the slider's handle, and what the trim leaves out in the dark."""
    draw, top, bottom = imgui.get_window_draw_list(), area.corner.y, area.end.y
    if state.source.part.trim is not None and state.source.clip is not None:
        kept = scale.ends(*state.source.span)
        shade, ink = imgui.get_color_u32(theme.grey(0.05, 0.75)), imgui.get_color_u32(theme.MARK)
        for left, right in ((area.corner.x, kept[0]), (kept[1], area.end.x)):
            draw.add_rect_filled((left, top), (right, bottom), shade)
        for x in kept:
            draw.add_line((x, top), (x, bottom), ink, em(0.15))
    if scale.count > 1:
        left, right = scale.ends(state.moment, state.moment)
        draw.add_rect((left, top), (right, bottom), imgui.get_color_u32(theme.INK), 0, em(0.12))
