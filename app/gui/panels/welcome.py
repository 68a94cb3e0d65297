"""The first page, while nothing is open: where to drop a case, what was opened lately, what is done here."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Final

from imgui_bundle import ImVec2, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons

from app.files.legible import in_one_line
from app.gui.actions import actions, live_actions
from app.gui.commands.command import Act
from app.gui.commands.commands import open_file, open_folder
from app.gui.drawing.textures import ShowsPictures
from app.gui.panels.overlays import covered
from app.gui.panels.small_picture import draw_small
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.style.labels import tag
from app.gui.style.widgets import Area, button, centered, em, explain, muted, shortened, width_of
from app.gui.views.recent_names import told_apart
from app.gui.work.recents import Kind, Recent

WIDEST: Final = 74.0
"""Text heights across that the page has at most."""
DROP: Final = (8.6, 13.0)
"""Text heights of the drop area, at least and at most."""
TILE: Final = 10.0
"""Text heights across that a recent case has at least."""
MOST_TILES: Final = 6
CARD: Final = 16.5
"""Text heights across that a card has at least."""
SHAPE: Final = 1.6
"""Width by height of images on this page."""
DASH: Final = 0.5
TITLE: Final = "Make blood vessels visible"
DROP_TEXT: Final = "Drop a folder, an image, a video or a splat file here"
SHORT_TEXT: Final = "Drop a case here"
UNKNOWN: Final = Recent("clip")
ICONS: Final[dict[Kind, str]] = {
    "clip": icons.ICON_FA_FILM, "run": icons.ICON_FA_CUBE,
    "splats": icons.ICON_FA_CUBE, "report": icons.ICON_FA_CHART_BAR,
}  # fmt: skip
CHOICES: Final[tuple[tuple[str, Act], ...]] = (
    (f"{icons.ICON_FA_FOLDER_OPEN}   Open folder…", open_folder),
    (f"{icons.ICON_FA_FILM}   Open file…", open_file),
    (f"{icons.ICON_FA_VIDEO}   Live source…###live", live_actions.choose_source),
    (f"{icons.ICON_FA_MAGIC}   Try the built-in clip###phantom", actions.open_phantom),
)
SAMPLES: Final = (
    ("enhance.jpg", "Enhance", "Vessels stand out beside the original, live."),
    ("reconstruct.jpg", "Reconstruct", "Moving tissue as a 3D model, from any side."),
    (
        "measure.jpg",
        "Measure and export",
        "Distances, contrast, depth; images that record how they were made.",
    ),
)


def draw_welcome(state: AppState, textures: ShowsPictures) -> None:
    """From top to bottom; it scrolls where that is not high enough."""
    space = imgui.get_content_region_avail()
    width = min(space.x, em(WIDEST))
    margin = imgui.get_cursor_pos_x() + (space.x - width) / 2
    tall = _needed(state, width, tall=True) < space.y
    rest, error = space.y - _needed(state, width, tall=tall), covered(state, imgui.get_cursor_screen_pos().y)
    height = min(max(em(DROP[0]) + 0.4 * (rest - error), em(DROP[0])), em(DROP[1]))
    imgui.dummy(ImVec2(0, max((rest - height + em(DROP[0])) / 3, error)))
    with imgui_ctx.push_font(None, 1.5 * theme.FONT_SIZE):
        centered(TITLE, theme.now().text)
    imgui.spacing()
    imgui.set_cursor_pos_x(margin)
    _draw_drop(state, Area.here(ImVec2(width, height)))
    if state.settings.recent:
        _heading("Recent", margin)
        _draw_recents(state, textures, margin, width)
    _heading("What it does", margin)
    _draw_samples(state, textures, margin, width, tall=tall)


def _needed(state: AppState, width: float, *, tall: bool) -> float:
    """Height of the whole with the lowest drop area."""
    line, gap = imgui.get_text_line_height_with_spacing(), imgui.get_style().item_spacing.y
    _, across = _row(width, TILE, MOST_TILES)
    recent = 2 * line + 2 * gap + across / SHAPE + line if state.settings.recent else 0
    in_row, card = _cards(width)
    cards = 2 * line + (len(SAMPLES) // in_row) * (_card_height(card, tall=tall) + gap)
    return em(DROP[0]) + 1.5 * em() + 3 * gap + recent + cards


def _heading(text: str, margin: float) -> None:
    imgui.dummy(ImVec2(0, em(0.2)))
    imgui.set_cursor_pos_x(margin)
    muted(text)


def _draw_drop(state: AppState, area: Area) -> None:
    """A dashed field with what to open in its middle."""
    draw, ink = imgui.get_window_draw_list(), imgui.get_color_u32(theme.now().edge)
    draw.add_rect_filled(area.corner, area.end, imgui.get_color_u32(theme.now().veil(0.03)), em(0.4))
    _draw_dashes(area, ink)
    start, line, pad = imgui.get_cursor_pos(), imgui.get_frame_height_with_spacing(), em(1)
    stacked = area.size.x < _width_of_choices() + 2 * pad
    content = em(3.0) + line + (len(CHOICES) if stacked else 1) * line
    top = start.y + max((area.size.y - content) / 2, em(0.3))
    imgui.set_cursor_pos(ImVec2(imgui.get_cursor_start_pos().x, top))
    if not stacked or area.size.y > content:
        with imgui_ctx.push_font(None, 2.2 * theme.FONT_SIZE):
            centered(icons.ICON_FA_DOWNLOAD)
    centered(state.opens or (SHORT_TEXT if stacked else DROP_TEXT), theme.now().text)
    imgui.spacing()
    _draw_choices(state, area, stacked=stacked)
    imgui.set_cursor_pos(start)
    imgui.dummy(ImVec2(area.size.x, max(area.size.y, content)))


def _draw_dashes(area: Area, ink: int) -> None:
    draw, step, low, high = imgui.get_window_draw_list(), em(DASH), area.corner, area.end
    for place in range(int(area.size.x / step / 2) + 1):
        x = low.x + 2 * place * step
        for y in (low.y, high.y):
            draw.add_line(ImVec2(x, y), ImVec2(min(x + step, high.x), y), ink, em(0.08))
    for place in range(int(area.size.y / step / 2) + 1):
        y = low.y + 2 * place * step
        for x in (low.x, high.x):
            draw.add_line(ImVec2(x, y), ImVec2(x, min(y + step, high.y)), ink, em(0.08))


def _width_of_choices() -> float:
    return sum(width_of(label) for label, _ in CHOICES) + (len(CHOICES) - 1) * em(0.6)


def _draw_choices(state: AppState, area: Area, *, stacked: bool) -> None:
    """In a line, or below each other; the built-in clip leads where nothing has been opened yet."""
    width = _width_of_choices()
    for place, (label, act) in enumerate(CHOICES):
        if stacked:
            width = width_of(label)
        if stacked or place == 0:
            x = area.corner.x + (area.size.x - width) / 2
            imgui.set_cursor_screen_pos(ImVec2(x, imgui.get_cursor_screen_pos().y))
        else:
            imgui.same_line(0, em(0.6))
        first = act is actions.open_phantom and not state.settings.recent
        button(label, partial(act, state), color=theme.now().lit if first else None)


def _row(width: float, least: float, most: int) -> tuple[int, float]:
    """How many stand in a row of that width, and how wide each is."""
    gap = imgui.get_style().item_spacing.x
    count = max(1, min(most, int((width + gap) / (em(least) + gap))))
    return count, (width - (count - 1) * gap) / count


def _draw_recents(state: AppState, textures: ShowsPictures, margin: float, width: float) -> None:
    """One row of recent files, the newest first."""
    count, across = _row(width, TILE, MOST_TILES)
    imgui.set_cursor_pos_x(margin)
    for place, name in enumerate(told_apart(state.settings.recent)[:count]):
        if place:
            imgui.same_line()
        _draw_recent(state, textures, place, name, across)


def _draw_recent(state: AppState, textures: ShowsPictures, place: int, name: str, across: float) -> None:
    """Image over name, a button; greyed where nothing is there any more."""
    slot, text = f"recent {place}", state.settings.recent[place]
    recent = state.welcome.recents.get(text, UNKNOWN)
    image, line = Area.here(ImVec2(across, across / SHAPE)), imgui.get_text_line_height_with_spacing()
    imgui.begin_disabled(recent.missing)
    pressed = imgui.invisible_button(slot, image.size + ImVec2(0, line))
    hovered = imgui.is_item_hovered() or imgui.is_item_focused()
    imgui.end_disabled()
    explain(f"Not found: {text}" if recent.missing else text)
    draw, colors = imgui.get_window_draw_list(), theme.now()
    ink = imgui.get_color_u32(imgui.Col_.text_disabled if recent.missing else imgui.Col_.text, 1.0)
    draw.add_rect_filled(image.corner, image.end, imgui.get_color_u32(theme.SURROUND), em(0.2))
    icon = icons.ICON_FA_UNLINK if recent.missing else ICONS[recent.kind]
    draw_small(textures, slot, recent.image, image, icon, theme.grey(0.6))
    if recent.image is not None and recent.kind == "run":
        tag("3D", image.corner + ImVec2(em(0.3), em(0.3)), theme.TAG_ORIGINAL)
    if hovered and not recent.missing:
        draw.add_rect(
            image.corner, image.end, imgui.get_color_u32(colors.accent), em(0.2), thickness=em(0.12)
        )
    shown = shortened(in_one_line(name), across)
    draw.add_text(ImVec2(image.corner.x, image.end.y + em(0.15)), ink, shown)
    if pressed:
        actions.open_path(state, Path(text))


def _cards(width: float) -> tuple[int, float]:
    """All in a row, or below each other: how many in each, and how wide."""
    count, across = _row(width, CARD, len(SAMPLES))
    return (count, across) if count == len(SAMPLES) else (1, width)


def _draw_samples(
    state: AppState, textures: ShowsPictures, margin: float, width: float, *, tall: bool
) -> None:
    """Three cards: an image, and what is done beside it, or below where there is room."""
    count, across = _cards(width)
    for place, (name, title, text) in enumerate(SAMPLES):
        if place % count:
            imgui.same_line()
        else:
            imgui.set_cursor_pos_x(margin)
        size = ImVec2(across, _card_height(across, tall=tall))
        with imgui_ctx.begin_child(name, size, 0, imgui.WindowFlags_.no_scrollbar):
            image = state.welcome.samples.get(name)
            high = across / SHAPE if tall else size.y
            area = Area.here(ImVec2(high * SHAPE, high))
            if image is not None:
                imgui.get_window_draw_list().add_image(textures.whole(name, image), area.corner, area.end)
            imgui.dummy(area.size)
            _draw_words(title, text, beside=not tall)


def _card_height(across: float, *, tall: bool) -> float:
    if tall:
        return across / SHAPE + 3.3 * imgui.get_text_line_height_with_spacing()
    return min(max(0.48 * across / SHAPE, em(5.6)), em(8))


def _draw_words(title: str, text: str, *, beside: bool) -> None:
    if beside:
        imgui.same_line(0, em(0.7))
    with imgui_ctx.begin_group(), imgui_ctx.push_text_wrap_pos(0):
        imgui.text_unformatted(title)
        imgui.text_colored(theme.now().muted, text)
