"""The command palette: words are typed, the arrows choose, Enter runs, Escape closes."""

from __future__ import annotations

from imgui_bundle import ImVec2, imgui, imgui_ctx

from app.files.legible import in_one_line
from app.gui.commands.command import Section
from app.gui.commands.finding import Found, find, find_help
from app.gui.state.app_state import AppState
from app.gui.style.widgets import em, explain_entry, mark_row, muted, shortened
from app.gui.views.key_words import with_keys

NAME = "##palette"
ROWS = 12.0
NONE = "No command matches. All names are in English; these may help:"
FLAGS = (
    imgui.WindowFlags_.no_title_bar | imgui.WindowFlags_.no_move | imgui.WindowFlags_.no_resize
    | imgui.WindowFlags_.no_saved_settings | imgui.WindowFlags_.no_nav
)  # fmt: skip


def draw_palette(state: AppState, sections: tuple[Section, ...]) -> None:
    """Over the window, until a command is run or it is closed."""
    palette = state.window.palette
    if not palette.shown:
        return
    appears = not imgui.is_popup_open(NAME)
    if appears:
        imgui.open_popup(NAME)
    viewport = imgui.get_main_viewport()
    top = ImVec2(viewport.get_center().x, viewport.work_pos.y + em(2))
    imgui.set_next_window_pos(top, imgui.Cond_.always, ImVec2(0.5, 0))
    imgui.set_next_window_size(ImVec2(min(em(38), viewport.work_size.x - em(2)), 0))
    with imgui_ctx.begin_popup(NAME, FLAGS) as opened:
        # A click beside it closes the popup.
        stays = bool(opened) and not imgui.is_key_pressed(imgui.Key.escape)
        palette.stay(stays)
        if not opened:
            return
        if appears:
            imgui.set_keyboard_focus_here()
        imgui.set_next_item_width(-1)
        _, words = imgui.input_text_with_hint("##words", "Type to find a command", palette.words)
        palette.type(words)
        matching = find(sections, palette.words, state)
        found = matching or find_help(sections, state)
        by = imgui.is_key_pressed(imgui.Key.down_arrow) - imgui.is_key_pressed(imgui.Key.up_arrow)
        if by:
            palette.move(by, len(found))
        chosen = _draw_found(state, found, palette.marked, by != 0, "" if matching else NONE)
        if imgui.is_key_pressed(imgui.Key.enter) or imgui.is_key_pressed(imgui.Key.keypad_enter):
            chosen = found[palette.marked]
        runs = chosen is not None and chosen.applies
        if not stays or runs:
            palette.stay(False)
            imgui.close_current_popup()
    if chosen is not None and runs:
        chosen.command.act(state)


def _draw_found(state: AppState, found: list[Found], marked: int, moved: bool, heading: str) -> Found | None:
    """The list, and what was clicked in it."""
    chosen = None
    height = imgui.get_text_line_height_with_spacing()
    with imgui_ctx.begin_child("found", ImVec2(0, ROWS * height), 0, imgui.WindowFlags_.no_nav):
        if heading:
            muted(heading)
        for place, one in enumerate(found):
            if _draw_row(state, one, place, place == marked):
                chosen = one
            if moved and place == marked:
                imgui.set_scroll_here_y()
    return chosen


def _draw_row(state: AppState, one: Found, place: int, marked: bool) -> bool:
    """Name on the left, menu and key on the right; greyed when it does not apply now."""
    start, can = imgui.get_cursor_pos_x(), imgui.SelectableFlags_
    flags = can.none if one.applies else can.disabled
    name = shortened(in_one_line(one.name), em(19.5))
    clicked, _ = imgui.selectable(f"{name}##{place}", marked, flags)
    if marked:
        mark_row()
    explain_entry(one.command.tooltip(state))
    keys = with_keys(one.command.keys[0]) if one.command.keys else ""
    for text, x in ((one.where, em(20)), (keys, em(29))):
        imgui.same_line(start + x)
        muted(text)
    return clicked
