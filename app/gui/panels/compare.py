"""The two panes: left the original by default, right the enhanced one, zoom and pan linked."""

from __future__ import annotations

from functools import partial

from imgui_bundle import ImVec2, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons

from app.enhancement.frame_enhancer import Pictures
from app.enhancement.settable import MODES, SLOTS, SOURCES
from app.gui.actions import actions, comparing, laid_out, picture_actions
from app.gui.commands.commands import one_to_one
from app.gui.drawing.textures import ShowsPictures
from app.gui.panels.fainter import draw_fainter
from app.gui.panels.picture_pane import Area, draw_bar, draw_divider, draw_side, draw_single
from app.gui.panels.welcome import draw_welcome
from app.gui.state.app_state import AppState
from app.gui.state.panes import difference_pane, pane, shown_mode, why_not
from app.gui.style import theme
from app.gui.style.widgets import beside, beside_of, button, centered, em, explain
from app.gui.views.comparison import SIDES, Side, label_of

MODE_LABELS = [mode.capitalize() for mode in MODES]
MODE_TEXT = (
    "V: side by side. W: wipe, with a line to drag. T: one pane that flips between left and "
    "right. D: where and by how much they differ."
)
ZEBRA_TEXT = "Z: stripes on clipped pixels: magenta where a channel is at 255, blue where all are at 0."


def draw_compare(state: AppState, textures: ShowsPictures) -> None:
    """Both pictures with their tags, or what to do when there is no clip yet."""
    if state.source.clip is None:
        draw_welcome(state)
        return
    _draw_toolbar(state)
    gap = em(0.3)
    half = max((imgui.get_content_region_avail().x - gap) / 2, em(4))
    _draw_sources(state, half, gap)
    if state.picture.pictures is None:
        imgui.dummy(ImVec2(0, em(4)))
        centered("Reading the first frame…")
        return
    draw_fainter(state)
    space = imgui.get_content_region_avail()
    height = max(space.y, em(4))
    if shown_mode(state) == "side by side":
        _draw_pair(state, state.picture.pictures, textures, ImVec2(half, height), gap)
    else:
        _draw_one(state, state.picture.pictures, textures, ImVec2(2 * half + gap, height))


def _draw_toolbar(state: AppState) -> None:
    label = "Enhancement on" if state.enhancement.active else "Enhancement off"
    with imgui_ctx.push_style_color(imgui.Col_.button, theme.switch(state.enhancement.active)):
        button(f"{label}###enhancing", lambda: actions.toggle_enhancement(state), width=8)
    explain("E: on or off. Esc: plain white light. Hold Space: the original in every pane.")
    beside("Frozen")
    freezing = state.timeline.frozen_index is not None
    with imgui_ctx.push_style_color(imgui.Col_.button, theme.switch(freezing, caution=True)):
        button("Frozen###freeze" if freezing else "Freeze###freeze", lambda: actions.toggle_freeze(state))
    explain("F: hold this frame in both panes while the clip plays on.")
    beside_of(em(7), 1)
    _draw_modes(state)
    fit = f"{icons.ICON_FA_EXPAND}  Fit"
    beside(fit, 1)
    button(fit, lambda: picture_actions.fit(state))
    explain("0 or double click: fit the whole frame.")
    beside("1:1")
    button("1:1", lambda: one_to_one(state))
    explain("1: actual pixels (1:1).")
    beside_of(em(4))
    imgui.align_text_to_frame_padding()
    imgui.text_colored(theme.now().muted, f"{100 * state.picture.zoom:.0f} %".rjust(6))
    explain("Screen pixels per image pixel.")
    _draw_slots(state)


def _draw_slots(state: AppState) -> None:
    for slot, gap in zip(SLOTS, (1.0, 0.5), strict=True):
        beside(f"Store {slot}", gap)
        button(f"Store {slot}", partial(comparing.store, state, slot))
        explain(f"Shift+{slot}: store the current settings as {slot}, to compare with or return to.")


def _draw_modes(state: AppState) -> None:
    imgui.set_next_item_width(em(7))
    now = MODES.index(state.comparing.chosen.mode)
    changed, chosen = imgui.combo("##mode", now, MODE_LABELS)
    explain(MODE_TEXT)
    if changed and chosen != now:
        comparing.choose_mode(state, MODES[chosen])
    beside("Zebra")
    with imgui_ctx.push_style_color(imgui.Col_.button, theme.switch(state.comparing.chosen.zebra)):
        button("Zebra", lambda: comparing.toggle_zebra(state))
    explain(ZEBRA_TEXT)


def _draw_sources(state: AppState, half: float, gap: float) -> None:
    """Above each pane what it shows."""
    start = imgui.get_cursor_pos_x()
    _draw_source(state, "left", half - em(4))
    imgui.same_line()
    button("Swap", lambda: comparing.swap(state))
    explain("X: swap left and right.")
    imgui.same_line(start + half + gap)
    _draw_source(state, "right", half)


def _draw_source(state: AppState, side: Side, width: float) -> None:
    source = state.comparing.chosen.source(side)
    imgui.set_next_item_width(min(width, em(15)))
    if imgui.begin_combo(f"##{side}", label_of(source), imgui.ComboFlags_.height_large):
        for choice in SOURCES:
            reason = why_not(state, choice)
            flags = imgui.SelectableFlags_.disabled if reason else 0
            chosen, _ = imgui.selectable(label_of(choice), choice == source, flags)
            explain(reason)
            if chosen:
                comparing.choose_source(state, side, choice)
        imgui.end_combo()
    explain(f"What the {side} side shows. The original belongs on the left.")


def _draw_pair(
    state: AppState, pictures: Pictures, textures: ShowsPictures, size: ImVec2, gap: float
) -> None:
    panes = {side: pane(state, pictures, side) for side in SIDES}
    pointer = None
    for side, shown in panes.items():
        if side == "right":
            imgui.same_line(0, gap)
        area = Area.here(size)
        pointer = draw_side(state, textures, side, shown, area) or pointer
    laid_out.point(state, pointer)


def _draw_one(state: AppState, pictures: Pictures, textures: ShowsPictures, size: ImVec2) -> None:
    """Wipe, flip or difference: one pane for both."""
    area, mode = Area.here(size), shown_mode(state)
    left, right = (pane(state, pictures, side) for side in SIDES)
    if mode == "wipe":
        laid_out.point(state, draw_divider(state, textures, left, right, area))
        return
    difference = state.comparing.difference
    if mode == "difference" and difference is not None and not state.enhancement.peeking:
        heat = difference_pane(state, pictures, difference)
        laid_out.point(state, draw_single(state, textures, heat, (left, right), area))
        draw_bar(difference.top, area)
        return
    shown = left if state.comparing.chosen.flipped else right
    laid_out.point(state, draw_single(state, textures, shown, (left, right), area))
