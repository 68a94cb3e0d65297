"""The two panes: left the original by default, right the enhanced one, zoom and pan linked."""

from __future__ import annotations

from functools import partial

from imgui_bundle import ImVec2, imgui
from imgui_bundle import icons_fontawesome_4 as icons

from app.enhancement.frame_enhancer import Pictures
from app.enhancement.settable import MODES, SLOTS, SOURCES
from app.exports.comparison_images import heat_scale
from app.files.legible import capital, without_flags
from app.gui.actions import (
    clip_actions,
    comparing,
    enhancement_actions,
    laid_out,
    live_actions,
    picture_actions,
)
from app.gui.commands.commands import one_to_one
from app.gui.drawing.textures import ShowsPictures
from app.gui.panels.faint_vessels import draw_faint_vessels
from app.gui.panels.overlays import make_room
from app.gui.panels.picture_pane import draw_divider, draw_pane
from app.gui.panels.scene_marks import draw_color_bar
from app.gui.panels.welcome import draw_welcome
from app.gui.state.app_state import AppState
from app.gui.state.panes import difference_pane, pane, shown_mode, source_label, why_not
from app.gui.style import theme
from app.gui.style.widgets import (
    Area,
    beside,
    beside_of,
    button,
    centered,
    choose,
    em,
    explain,
    muted,
    note,
    shortened,
    toggle,
    width_of,
)
from app.gui.views.comparison import SIDES, Side

MODE_LABELS = {mode: mode.capitalize() for mode in MODES}
MODE_TEXT = (
    "V: side by side. W: wipe, with a line to drag. T: one pane that flips between left and "
    "right. D: where and by how much they differ."
)
ENHANCING_TEXT = "E: on or off. Shift+W: plain white light. Hold O: the original in every pane."
FREEZE_TEXT = "F: hold this frame in both panes while the clip plays on, or the live source goes on."
NOTICES_TEXT = "Hide this. It stays in the log."
ZEBRA_TEXT = "Z: stripes on clipped pixels: magenta where a channel is at 255, yellow where all are at 0."


def draw_compare(state: AppState, textures: ShowsPictures) -> None:
    """Both pictures with their tags, or what to do when there is no clip yet."""
    if state.source.clip is None:
        draw_welcome(state, textures)
        return
    make_room(state)
    _draw_toolbar(state)
    gap = em(0.3)
    half = max((imgui.get_content_region_avail().x - gap) / 2, em(4))
    _draw_sources(state, half, gap)
    if state.picture.pictures is None:
        imgui.dummy(ImVec2(0, em(4)))
        reading = "Reading the first frame…" if len(state.source.clip) > 1 else "Reading the image…"
        centered("This frame cannot be read." if state.is_unreadable else reading)
        return
    _draw_notices(state)
    height = max(imgui.get_content_region_avail().y, em(4))
    area = Area.here(ImVec2(2 * half + gap, height))
    covered = draw_faint_vessels(state, area)
    if shown_mode(state) == "side by side":
        _draw_pair(state, state.picture.pictures, textures, ImVec2(half, height), gap, covered)
    else:
        _draw_one(state, state.picture.pictures, textures, area, covered)


def _draw_toolbar(state: AppState) -> None:
    chosen, label = state.comparing.chosen, f"Enhancement {'on' if state.enhancement.active else 'off'}"
    turn, active = partial(enhancement_actions.toggle_enhancement, state), state.enhancement.active
    toggle(f"{label}###enhancing", turn, ENHANCING_TEXT, on=active, width=8)
    beside("Frozen")
    frozen, freeze = state.is_frozen, partial(live_actions.toggle_freeze, state)
    label = "Frozen###freeze" if frozen else "Freeze###freeze"
    toggle(label, freeze, FREEZE_TEXT, on=frozen, caution=True)
    beside_of(em(7))
    mode = choose("mode", chosen.mode, MODE_LABELS, MODE_TEXT, 7)
    if mode != chosen.mode:
        comparing.choose_mode(state, mode)
    beside("Zebra")
    toggle("Zebra", partial(comparing.toggle_zebra, state), ZEBRA_TEXT, on=chosen.zebra)
    fit = f"{icons.ICON_FA_EXPAND}  Fit"
    beside(fit)
    button(fit, partial(picture_actions.fit, state.picture), "0 or double click: fit the whole frame.")
    beside("1:1")
    button("1:1", partial(one_to_one, state), "1: actual pixels (1:1).")
    beside_of(em(4))
    imgui.align_text_to_frame_padding()
    muted(f"{100 * state.picture.zoom:.0f} %".rjust(6))
    explain("Screen pixels per image pixel.")
    gap, labels = em(0.5), [f"Store {slot}" for slot in SLOTS]
    # Together: one of them alone on a line looks left over.
    beside_of(sum(map(width_of, labels)) + gap * (len(labels) - 1))
    for place, slot in enumerate(SLOTS):
        text = f"Shift+{slot}: store the current settings as {slot}, to compare with or return to."
        if place:
            imgui.same_line(0, gap)
        button(f"Store {slot}", partial(comparing.store, state, slot), text)


def _draw_sources(state: AppState, half: float, gap: float) -> None:
    """Above each pane what it shows."""
    start = imgui.get_cursor_pos_x()
    _draw_source(state, "left", half - em(4))
    imgui.same_line()
    button("Swap", partial(comparing.swap, state), "X: swap left and right.")
    imgui.same_line(start + half + gap)
    _draw_source(state, "right", half)


def _draw_source(state: AppState, side: Side, width: float) -> None:
    source = state.comparing.chosen.source(side)
    width = min(width, em(15))
    imgui.set_next_item_width(width)
    room = width - imgui.get_frame_height() - 2 * imgui.get_style().frame_padding.x
    shown = shortened(source_label(state, source), room)
    if imgui.begin_combo(f"##{side}", shown, imgui.ComboFlags_.height_large):
        for choice in SOURCES:
            reason = why_not(state, choice)
            flags = imgui.SelectableFlags_.disabled if reason else 0
            chosen, _ = imgui.selectable(source_label(state, choice), choice == source, flags)
            explain(reason)
            if chosen:
                comparing.choose_source(state, side, choice)
        imgui.end_combo()
    explain(f"What the {side} side shows. The original belongs on the left.")


def _draw_pair(
    state: AppState, pictures: Pictures, textures: ShowsPictures, size: ImVec2, gap: float, covered: float
) -> None:
    panes, pointer = {side: pane(state, pictures, side) for side in SIDES}, None
    for side, shown in panes.items():
        if side == "right":
            imgui.same_line(0, gap)
        area = Area.here(size)
        pointer = draw_pane(state, textures, side, shown, (shown,), area, covered=covered) or pointer
    laid_out.point(state, pointer)


def _draw_one(
    state: AppState, pictures: Pictures, textures: ShowsPictures, area: Area, covered: float
) -> None:
    """Wipe, flip or difference: one pane for both."""
    mode, difference = shown_mode(state), state.comparing.difference
    left, right = (pane(state, pictures, side) for side in SIDES)
    if mode == "wipe":
        laid_out.point(state, draw_divider(state, textures, left, right, area, covered))
        return
    shown = left if state.comparing.chosen.flipped else right
    if mode != "difference" or state.enhancement.peeking:
        difference = None
    if difference is not None:
        shown = difference_pane(left, right, difference)
    pointer = draw_pane(state, textures, "single", shown, (left, right), area, covered=covered)
    laid_out.point(state, pointer)
    if difference is not None:
        _draw_scale(difference.top, area)


def _draw_scale(top: int, area: Area) -> None:
    """Of the heat map, whose last colour stands for all above it, too."""
    last = f"{top}" if top == 255 else f"≥{top}"
    draw_color_bar(heat_scale(top), area, {0: "0", top / 2: f"{top / 2:.0f}", top: last})


def _draw_notices(state: AppState) -> None:
    """What the open video is read as, until it has been read."""
    start = 0.0
    for place, notice in enumerate(state.source.notices):
        if place == 0:
            button("OK##notices", partial(clip_actions.dismiss_notices, state), NOTICES_TEXT, small=True)
            start = imgui.get_item_rect_size().x
        else:
            imgui.dummy(ImVec2(start, 0))
        imgui.same_line(0, em(0.5))
        note(f"{capital(without_flags(notice))}.", theme.now().text)
