"""The case summary: which pictures are on its page, in which order, with which notes."""

from __future__ import annotations

from functools import partial

from imgui_bundle import ImVec2, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons

from app.exports.exporting import UNTITLED
from app.files.legible import in_one_line, legible, located
from app.gui.actions import actions, export_actions, summary_actions
from app.gui.drawing.textures import ShowsPictures
from app.gui.panels.overlays import floating_window
from app.gui.panels.small_picture import draw_small
from app.gui.state.app_state import AppState
from app.gui.state.summary import Item
from app.gui.style import theme
from app.gui.style.widgets import FLAT, Area, beside_of, button, em, explain, muted, note, row, shortened
from app.gui.style.writing import text_area

TEXT = (
    "Images on one page with their settings, measures and your notes, to print or to send. Any browser "
    "opens it, and saves it as PDF when printing."
)
TITLE = "Case summary"
TITLE_TEXT = "The heading of the page, and the name of its file. Write no patient's name on what you send."
NOTES_TEXT = "Above the images. Kept with the session."
ITEM_HINT = "Note below this image"
SHOWN_TEXT = "Save what is shown now as an image, and add it."
CASE_TEXT = "Adds what is under View > Notes below the notes above."
FILE_TEXT = "A PNG or JPEG image that VesselSplat saved before."
REMOVE_TEXT = "Remove from the page; the file stays. Ctrl+Z undoes it."
WIDTH, HEIGHT = 8.5, 5.2
"""Text heights across and down, for a thumbnail."""
MOVING = 5.6
"""Text heights across that the buttons beside a name take."""
LISTED = 3
"""Pictures before the list scrolls."""


def draw_summary(state: AppState, textures: ShowsPictures) -> None:
    """A window of its own."""
    if not state.summary.shown:
        return
    with floating_window(state, state.summary, TITLE, 40) as drawn:
        if not drawn:
            return
        note(TEXT)
        imgui.spacing()
        _draw_texts(state)
        imgui.spacing()
        _draw_adding(state)
        _draw_items(state, textures)
        imgui.spacing()
        _draw_writing(state)


def _draw_texts(state: AppState) -> None:
    row("Title", TITLE_TEXT)
    changed, title = imgui.input_text_with_hint("##title", UNTITLED, state.summary.title)
    explain(TITLE_TEXT)
    if changed:
        summary_actions.type_title(state, title)
    row("Notes", NOTES_TEXT)
    changed, notes = text_area("##notes", "", state.summary.notes, ImVec2(-0.1, em(3.4)))
    explain(NOTES_TEXT)
    if changed:
        summary_actions.type_notes(state, notes)


def _draw_adding(state: AppState) -> None:
    reason, plus = summary_actions.why_not_add(state), icons.ICON_FA_PLUS
    add = partial(summary_actions.add_shown, state)
    button(f"{plus}  What is shown###add shown", add, SHOWN_TEXT, reason=reason, width=11)
    imgui.same_line()
    choose = partial(actions.choose_path, state, "file", summary_actions.add_file, "picture")
    button(f"{plus}  Saved image…###add file", choose, FILE_TEXT, width=11)
    beside_of(em(11))
    reason, add = summary_actions.why_not_add_notes(state), partial(summary_actions.add_notes, state)
    button(f"{plus}  Notes of the case###add notes", add, CASE_TEXT, reason=reason, width=11)
    if state.summary.awaited:
        imgui.same_line()
        muted("Saving the image…")


def _draw_items(state: AppState, textures: ShowsPictures) -> None:
    items = state.summary.items
    lines = min(max(len(items), 1), LISTED)
    height = lines * (em(HEIGHT) + 2 * imgui.get_style().item_spacing.y) + em(1)
    with imgui_ctx.begin_child("pictures", ImVec2(0, height), imgui.ChildFlags_.borders | FLAT):
        if not items:
            muted("No image yet.")
        for place, item in enumerate(items):
            with imgui_ctx.push_id(str(item.path)):
                _draw_item(state, place, item, textures)
            imgui.spacing()


def _draw_item(state: AppState, place: int, item: Item, textures: ShowsPictures) -> None:
    image, area = state.summary.thumbnails.get(item.path), Area.here(ImVec2(em(WIDTH), em(HEIGHT)))
    draw_small(textures, f"summary {place}", image, area, icons.ICON_FA_FILE)
    imgui.dummy(area.size)
    explain(legible(str(item.path)))
    imgui.same_line()
    with imgui_ctx.begin_group():
        imgui.align_text_to_frame_padding()
        width = imgui.get_content_region_avail().x - em(MOVING + 0.5)
        imgui.text_unformatted(shortened(f"{place + 1}.  {in_one_line(item.path.name)}", width))
        _draw_moving(state, place)
        size = ImVec2(-0.1, em(HEIGHT) - imgui.get_frame_height_with_spacing())
        changed, text = text_area("##note", ITEM_HINT, item.note, size)
        explain("A note below this image.")
        if changed:
            summary_actions.type_note(state, place, text)


def _draw_moving(state: AppState, place: int) -> None:
    """At the right end of the line."""
    last = len(state.summary.items) - 1
    buttons = (
        (f"{icons.ICON_FA_ARROW_UP}###up", partial(summary_actions.move, state, place, -1), "Up.", place > 0),
        (f"{icons.ICON_FA_ARROW_DOWN}###down", partial(summary_actions.move, state, place, 1), "Down.",
         place < last),
        (f"{icons.ICON_FA_TRASH}###remove", partial(summary_actions.remove, state, place), REMOVE_TEXT, True),
    )  # fmt: skip
    imgui.same_line(imgui.get_content_region_avail().x - em(MOVING))
    for label, act, text, enabled in buttons:
        button(label, act, text, enabled=enabled, width=1.7)
        imgui.same_line(0, em(0.25))
    imgui.new_line()


def _draw_writing(state: AppState) -> None:
    if state.exports.under_way is not None:
        room = imgui.get_content_region_avail().x - em(6)
        imgui.align_text_to_frame_padding()
        muted(shortened(f"Writing {legible(export_actions.name_written(state))}", room - em(0.5)))
        # Not where Save stood: the second click of a double click would cancel.
        imgui.same_line(imgui.get_cursor_pos_x() + room)
        button("Cancel", partial(export_actions.cancelled, state), "No file is left incomplete.", width=6)
        return
    reason, color = summary_actions.why_not_write(state), theme.now().lit
    write = partial(summary_actions.write_page, state)
    button("Save page###write", write, reason=reason, color=color, width=10)
    imgui.same_line()
    muted(reason or f"into {legible(located(state.export_folder)).rstrip('/')}")
