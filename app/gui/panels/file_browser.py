"""The file dialog inside the window: a list with thumbnails, by mouse and by keyboard."""

from __future__ import annotations

from functools import partial

from imgui_bundle import ImVec2, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons

from app.files.legible import in_one_line, legible
from app.gui.actions import browse_actions
from app.gui.drawing.textures import ShowsPictures
from app.gui.panels.small_picture import draw_small
from app.gui.state.app_state import AppState
from app.gui.state.browsing import Browsing, Column
from app.gui.style import theme
from app.gui.style.asking import close_question
from app.gui.style.widgets import (
    Area,
    button,
    centered,
    choose,
    em,
    explain,
    mark_row,
    muted,
    shortened,
    within,
)
from app.gui.views.key_words import with_keys
from app.gui.work.listing import Entry

ENTER = (imgui.Key.enter, imgui.Key.keypad_enter)
STEPS = {
    imgui.Key.down_arrow: 1, imgui.Key.up_arrow: -1, imgui.Key.page_down: 10, imgui.Key.page_up: -10
}  # fmt: skip
CLAIMED = (*STEPS, *ENTER, imgui.Key.escape)
"""They are of the list, whatever control has the focus."""
IN_LINE = (imgui.Key.left_arrow, imgui.Key.right_arrow, imgui.Key.home, imgui.Key.end)
"""They move in the line of the path, which is then edited."""
OWNER = 0x66696C65
"""Any number that no control has."""
COLUMNS: tuple[Column, ...] = ("name", "date", "size")
ROW, PICTURE = 2.6, 4.0
"""Text heights of a row, and across for its thumbnail."""
MOST_ROWS = 128
"""That are on screen at once."""
EMPTY = {
    "folder": "No subfolder. {verb} uses this folder and the files in it.",
    "target": "No subfolder. {verb} uses this folder.",
    "file": "No folder here, and no file of this kind.",
    "save": "No folder and no session here.",
}
WHOLE_FOLDER = "Open folder (Ctrl+O) opens a whole folder."
ONE_VIDEO = "Open file (Ctrl+I) lists the video here."
UP_TEXT = "Backspace or Alt+Up: the folder above."
HINTS = {
    "folder": "Enter goes in; Enter again {does} the folder.",
    "file": "Enter {does}, Backspace goes up, Esc cancels.",
    "save": "Enter saves, Esc cancels.",
}


def draw_browser(state: AppState, textures: ShowsPictures) -> None:
    """Everything else waits for it."""
    browsing = state.window.browsing
    if browsing is None:
        return
    title = browsing.choosing.question.title
    appears = not imgui.is_popup_open(title)
    if appears:
        imgui.open_popup(title)
    center = imgui.get_main_viewport().get_center()
    imgui.set_next_window_pos(center, imgui.Cond_.appearing, ImVec2(0.5, 0.5))
    imgui.set_next_window_size(within(52, 36), imgui.Cond_.appearing)
    with imgui_ctx.begin_popup_modal(title, imgui.WindowFlags_.no_saved_settings) as opened:
        if not opened:
            return
        # While a list of filters is open, keys are its own; nor do they count that have asked for the dialog.
        if not appears and not imgui.is_popup_open("", imgui.PopupFlags_.any_popup_id):
            _take_keys(state, browsing)
        _draw_all(state, browsing, textures)
        if state.window.browsing is None:
            close_question()


def _draw_all(state: AppState, browsing: Browsing, textures: ShowsPictures) -> None:
    saves = browsing.choosing.kind == "save"
    _draw_path(browsing, asks=not saves)
    line, flags = imgui.get_frame_height_with_spacing(), imgui.WindowFlags_.no_nav
    below = 2 * line if saves else line
    with imgui_ctx.begin_child("entries", ImVec2(0, -below), imgui.ChildFlags_.borders, flags):
        _draw_entries(state, browsing, textures)
    if saves:
        _draw_name(browsing)
    browse_actions.focused(browsing)
    _draw_choice(state, browsing)


def _draw_path(browsing: Browsing, *, asks: bool) -> None:
    """`asks`: it is what is typed into."""
    button(f"{icons.ICON_FA_ARROW_UP}##up", partial(browse_actions.go_up, browsing), UP_TEXT)
    imgui.same_line()
    _focus(browsing.focus and asks)
    changed, text = imgui.input_text(f"##path {browsing.line}", browsing.text)
    if changed or imgui.is_item_clicked():
        browse_actions.type_path(browsing, text)


def _focus(wanted: bool) -> None:
    """On the line that comes next, with what is in it selected."""
    if wanted:
        imgui.set_keyboard_focus_here()
    imgui.set_next_item_width(-1)


def _draw_entries(state: AppState, browsing: Browsing, textures: ShowsPictures) -> None:
    if browsing.listing is None:
        centered("Reading…")
    elif browsing.listing.trouble:
        centered(browsing.listing.trouble, theme.now().warning)
    elif not browsing.listing.entries:
        centered("This folder is empty.")
    elif not browsing.entries:
        is_target = browsing.choosing.question.keeps_itself
        centered(_in_verb(browsing, EMPTY["target" if is_target else browsing.choosing.kind]))
    else:
        _draw_table(state, browsing, textures)


def _draw_table(state: AppState, browsing: Browsing, textures: ShowsPictures) -> None:
    can, entries, seen = imgui.TableFlags_, browsing.entries, list[Entry]()
    flags = can.sortable | can.scroll_y | can.row_bg | can.pad_outer_x
    with imgui_ctx.begin_table("files", len(COLUMNS), int(flags)) as table:
        if not table:
            return
        _head(browsing)
        clipper, height = imgui.ListClipper(), em(ROW)
        clipper.begin(len(entries), height + 2 * imgui.get_style().cell_padding.y)
        if browsing.scroll and (place := _place(browsing)) is not None:
            clipper.include_item_by_index(place)
        while clipper.step():
            for place in range(clipper.display_start, clipper.display_end):
                if _draw_row(state, browsing, entries[place], place, textures):
                    seen.append(entries[place])
        browse_actions.see(browsing, seen)


def _head(browsing: Browsing) -> None:
    kind = imgui.TableColumnFlags_
    imgui.table_setup_scroll_freeze(0, 1)
    imgui.table_setup_column("Name", kind.width_stretch | kind.default_sort)
    imgui.table_setup_column("Changed", kind.width_fixed | kind.prefer_sort_descending, em(8.5))
    imgui.table_setup_column("Size", kind.width_fixed | kind.prefer_sort_descending, em(5))
    imgui.table_headers_row()
    specs = imgui.table_get_sort_specs()
    if specs.specs_count:
        first = specs.get_specs(0)
        descending = first.get_sort_direction() == imgui.SortDirection.descending
        browse_actions.sort(browsing, COLUMNS[first.column_index], descending=descending)


def _place(browsing: Browsing) -> int | None:
    """Where the marked entry is in the list; None: none is marked."""
    found = (place for place, entry in enumerate(browsing.entries) if entry.path == browsing.marked)
    return next(found, None)


def _draw_row(state: AppState, browsing: Browsing, entry: Entry, place: int, textures: ShowsPictures) -> bool:
    """Whether it is in sight."""
    height, marked = em(ROW), browsing.marked == entry.path
    imgui.table_next_row()
    imgui.table_next_column()
    flags, start, corner = imgui.SelectableFlags_, imgui.get_cursor_pos(), imgui.get_cursor_screen_pos()
    can = flags.no_auto_close_popups | flags.allow_double_click | flags.span_all_columns
    room = imgui.get_content_region_avail().x - em(PICTURE + 0.6)
    clicked, _ = imgui.selectable(f"##{place}", marked, can, ImVec2(0, height))
    in_sight = imgui.is_item_visible()
    if marked:
        mark_row()
    if clicked:
        browse_actions.mark(browsing, entry)
        if imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
            browse_actions.opens(state, browsing)
    if marked and browsing.scroll:
        imgui.set_scroll_here_y()
        browse_actions.scrolled(browsing)
    if in_sight:
        image, area = browsing.thumbnails.get(entry.path), Area(corner, ImVec2(em(PICTURE), height))
        icon = icons.ICON_FA_FOLDER if entry.kind == "folder" else icons.ICON_FA_FILE
        draw_small(textures, f"file {place % MOST_ROWS}", image, area, icon)
    low = start.y + (height - imgui.get_text_line_height()) / 2
    imgui.set_cursor_pos(ImVec2(start.x + em(PICTURE + 0.6), low))
    short = shortened(in_one_line(entry.name), room)
    imgui.text_unformatted(short)
    explain(entry.name if short != entry.name else "")
    for text in (browse_actions.dated(entry) if entry.kind else "", _sized(entry)):
        imgui.table_next_column()
        imgui.set_cursor_pos_y(low)
        muted(text)
    return in_sight


def _sized(entry: Entry) -> str:
    """Bytes as a person says them; of a folder, whose thumbnail is like a file's, that it is one."""
    if entry.kind != "file":
        return "folder" if entry.kind == "folder" else ""
    for unit, bytes_ in (("GB", 1e9), ("MB", 1e6)):
        if entry.size >= bytes_:
            return f"{entry.size / bytes_:.1f} {unit}"
    return f"{max(1, round(entry.size / 1e3))} kB" if entry.size else "0 kB"


def _draw_name(browsing: Browsing) -> None:
    imgui.align_text_to_frame_padding()
    imgui.text("Name")
    imgui.same_line()
    _focus(browsing.focus)
    changed, name = imgui.input_text(f"##name {browsing.line}", browsing.name)
    if changed:
        browse_actions.type_name(browsing, name)


def _draw_choice(state: AppState, browsing: Browsing) -> None:
    reason, saves = browse_actions.why_not(browsing), browsing.choosing.kind == "save"
    replaces = saves and not reason and browse_actions.replaces(browsing)
    label = "Replace" if replaces else browsing.choosing.question.verb
    color = theme.now().caution if replaces else theme.now().lit
    act = partial(browse_actions.choose, state, browsing)
    button(f"{label}###choose", act, reason=reason, color=color, width=6.5)
    imgui.same_line()
    button("Cancel", partial(browse_actions.cancel, state), width=6.5)
    filters = browsing.choosing.question.filters
    if len(filters) > 1 and not saves:
        imgui.same_line()
        labels = {place: one.label for place, one in enumerate(filters)}
        chosen = choose("filter", browsing.filter, labels, "Which files are listed.", 12)
        browse_actions.choose_filter(browsing, chosen)
    imgui.same_line()
    if replaces:
        imgui.text_colored(theme.now().warning, f"{legible(browse_actions.target(browsing).name)} exists.")
    else:
        typed = browsing.typed or (saves and browsing.name.strip())
        said = reason if reason and typed else with_keys(_hint(browsing))
        short = shortened(said, imgui.get_content_region_avail().x)
        muted(short)
        explain(said if short != said else "")


def _hint(browsing: Browsing) -> str:
    """Of a folder whose videos are not listed, where they are; where none is opened, what opens it."""
    if browsing.choosing.purpose == "file" and browsing.marked is None:
        return WHOLE_FOLDER
    videos = browsing.listing.videos if browsing.listing is not None else 0
    if browsing.choosing.kind == "folder" and browsing.choosing.question.takes_files and videos:
        return f"Open file (Ctrl+I) lists the {videos} videos here." if videos > 1 else ONE_VIDEO
    return _in_verb(browsing, HINTS[browsing.choosing.kind])


def _in_verb(browsing: Browsing, text: str) -> str:
    """With the word of the button that chooses."""
    verb = browsing.choosing.question.verb
    return text.format(verb=verb, does=f"{verb.lower()}s")


def _take_keys(state: AppState, browsing: Browsing) -> None:
    """Before any control, of which some would take them."""
    io, pressed = imgui.get_io(), imgui.is_key_pressed
    for key in CLAIMED:
        imgui.internal.set_key_owner(key, OWNER)
    edits = browsing.typed or browsing.choosing.kind == "save"
    back = pressed(imgui.Key.backspace, False) and not edits
    if any(pressed(key) for key in IN_LINE) and not browsing.typed:
        browse_actions.type_path(browsing, browsing.text)
    elif back or (pressed(imgui.Key.up_arrow, False) and io.key_alt):
        browse_actions.go_up(browsing)
    elif any(pressed(key, False) for key in ENTER):
        browse_actions.opens(state, browsing)
    elif pressed(imgui.Key.escape, False):
        browse_actions.cancel(state)
    elif not io.key_alt:
        for key, by in STEPS.items():
            if pressed(key):
                browse_actions.move(browsing, by)
