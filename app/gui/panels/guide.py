"""The guide: six pages from the first image to an export, turned by mouse and keyboard."""

from __future__ import annotations

from functools import partial
from typing import Final

from imgui_bundle import ImVec2, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons

from app.gui.actions import floating_windows, guide_actions
from app.gui.drawing.textures import ShowsPictures
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.style.widgets import FLAT, button, em, mark_row, muted, note, within
from app.gui.views.key_words import with_keys
from app.gui.work.shipped import Block, Guide, Page
from renderer.clip import ByteImage

LIST: Final = 13.0
"""Text heights across that the list of pages has."""
ROOMY: Final = 46.0
"""Text heights across that a window needs for the list."""
FOOT: Final = 2.3
TALLEST: Final = 0.62
"""Share of the page's height that an image has at most."""
LEAST: Final = 20.0
"""Text heights that it may have anyway: a low window scrolls."""
TURN_TEXT: Final = (
    "Page Up and Page Down turn pages, Esc closes, F1 opens the page of the panel under the pointer."
)


def draw_guide(state: AppState, textures: ShowsPictures) -> None:
    """A window over the others, which stay usable."""
    if not state.guide.shown:
        return
    center = imgui.get_main_viewport().get_center()
    imgui.set_next_window_pos(center, imgui.Cond_.appearing, ImVec2(0.5, 0.5))
    imgui.set_next_window_size(within(62, 40), imgui.Cond_.appearing)
    flags = imgui.WindowFlags_.no_collapse | imgui.WindowFlags_.no_docking
    with imgui_ctx.begin(guide_actions.TITLE, True, flags | imgui.WindowFlags_.no_saved_settings) as window:
        floating_windows.show(state.guide, bool(window.opened))
        guide = state.guide.pages
        if not window.expanded or guide is None:
            return
        height = imgui.get_content_region_avail().y - em(FOOT)
        if imgui.get_content_region_avail().x > em(ROOMY):
            with imgui_ctx.begin_child("pages", ImVec2(em(LIST), height), FLAT):
                _draw_list(state, guide)
            imgui.same_line(0, em(1))
        page = guide.pages[state.guide.page]
        # Of a name of its own, so that a page begins at its top.
        with imgui_ctx.begin_child(f"page {state.guide.page}", ImVec2(0, height)):
            _draw_page(page, guide, textures)
        _draw_foot(state, guide)


def _draw_list(state: AppState, guide: Guide) -> None:
    for place, page in enumerate(guide.pages):
        chosen, _ = imgui.selectable(f"{place + 1}   {page.title}", place == state.guide.page)
        if place == state.guide.page:
            mark_row()
        if chosen:
            guide_actions.turn_to(state, place)


def _draw_page(page: Page, guide: Guide, textures: ShowsPictures) -> None:
    with imgui_ctx.push_font(None, 1.35 * theme.FONT_SIZE):
        imgui.text_unformatted(page.title)
    imgui.spacing()
    for block in page.blocks:
        if block.role == "image":
            _draw_image(block, guide.images.get(block.name), textures)
        else:
            _draw_text(block)
        imgui.spacing()


def _draw_text(block: Block) -> None:
    with imgui_ctx.push_text_wrap_pos(0):
        if block.role == "point":
            imgui.bullet()
        imgui.text_unformatted(with_keys(block.text))


def _draw_image(block: Block, image: ByteImage | None, textures: ShowsPictures) -> None:
    """As wide as the page, but no larger than it was taken, and so that there is room for words."""
    if image is not None:
        rows, columns = image.shape[:2]
        most = max(TALLEST * imgui.get_window_height(), em(LEAST)) / rows
        scale = min(imgui.get_content_region_avail().x / columns, em() / theme.FONT_SIZE, most)
        size = ImVec2(scale * columns, scale * rows)
        imgui.image(textures.whole(f"guide {block.name}", image), size)
    note(block.text)


def _draw_foot(state: AppState, guide: Guide) -> None:
    page, last = state.guide.page, len(guide.pages) - 1
    imgui.spacing()
    back, on = (partial(guide_actions.turn, state, pages) for pages in (-1, 1))
    button(f"{icons.ICON_FA_CHEVRON_LEFT}  Back", back, TURN_TEXT, enabled=page > 0, width=7)
    imgui.same_line()
    button(f"Next  {icons.ICON_FA_CHEVRON_RIGHT}###next", on, TURN_TEXT, enabled=page < last, width=7)
    imgui.same_line(0, em(1))
    muted(f"{page + 1} of {last + 1}")
    imgui.same_line(imgui.get_window_width() - em(8))
    button("Close", partial(floating_windows.show, state.guide, False), width=7)
