"""One pane: the image where zoom and pan put it, its tags, the pixel under the pointer, the wipe's line."""

from __future__ import annotations

from collections.abc import Sequence

from imgui_bundle import ImVec2, imgui, imgui_ctx

from app.enhancement.frame_enhancer import PictureRequest
from app.files.legible import in_one_line
from app.gui.actions import clip_actions, comparing, laid_out, picture_actions, presenting
from app.gui.actions.picture_actions import Seen
from app.gui.drawing.textures import PLAIN, Marks, ShowsPictures
from app.gui.panels.masking import draw_brush, follow_brush, size_by_wheel
from app.gui.state.app_state import AppState
from app.gui.state.live_words import is_not_live
from app.gui.state.panes import Pane, pixel
from app.gui.state.tags import Tag, cautions
from app.gui.style import theme
from app.gui.style.labels import stack_tags, tag, tag_height
from app.gui.style.widgets import Area, dragged, em, fill_around
from app.gui.views.comparison import Side
from app.gui.views.picture_view import PictureView, Placement
from app.live.picture import LIVE
from renderer.clip import ByteImage

LOW = 14.0
"""Text heights of a pane that has little room for labels."""
WHEEL_STEP = 1.15
PANE_BUTTONS = imgui.ButtonFlags_.mouse_button_left | imgui.ButtonFlags_.mouse_button_right
NARROW = 20.0
"""Em across below which a pane says less."""
LEAST_SIDE = 8.0
"""Em across of a side of the line above which its tags are broken into lines."""
Pointer = tuple[int, int]


def draw_pane(
    state: AppState,
    textures: ShowsPictures,
    slot: str,
    pane: Pane,
    read: Sequence[Pane],
    area: Area,
    *,
    labels: bool = True,
    covered: float = 0.0,
) -> Pointer | None:
    """One picture in the area, and the values under the pointer in those that are `read`, one or both.

    Without `labels` it says only what could mislead; what it says at the bottom stands above so many pixels
    that are `covered`. Returns the picture position under the mouse if that is here.
    """
    pointer, crosses = _button(state, slot, pane.image, area), _draws_mask_here(state)
    with imgui_ctx.push_clip_rect(area.corner, area.end, True):
        _draw_image(state, textures, slot, pane, area)
        if state.masking.active:
            draw_brush(state, _placement(state, pane.image, area), area)
        if crosses:
            _cross_at(imgui.get_mouse_pos())
        if pointer is None and len(read) == 1:
            _draw_cross(state, pane.image, area)
        if is_not_live(state.live):
            _draw_rim(area)
        _draw_tags(pane.tags if labels else cautions(pane.tags), area.corner, area.size)
        if labels:
            _draw_readout(state, read, area, covered)
    return pointer


def draw_divider(
    state: AppState, textures: ShowsPictures, left: Pane, right: Pane, area: Area, covered: float
) -> Pointer | None:
    """Left and right of a line that can be dragged; each side has its own tags."""
    imgui.set_next_item_allow_overlap()
    pointer, crosses = _button(state, "wipe", left.image, area), _draws_mask_here(state)
    x = _drag_line(state, area)
    across = _placement(state, left.image, area).picture_at(x - area.corner.x, 0)[0] / left.image.shape[1]
    laid_out.place_wipe(state, across)
    with imgui_ctx.push_clip_rect(area.corner, area.end, True):
        for side, pane, start, end in (("left", left, area.corner.x, x), ("right", right, x, area.end.x)):
            with imgui_ctx.push_clip_rect(ImVec2(start, area.corner.y), ImVec2(end, area.end.y), True):
                _draw_image(state, textures, side, pane, area)
                # A side that is narrower than a word cuts its tags off: they would be columns of letters.
                wide = end - start if end - start > em(LEAST_SIDE) else area.size.x
                _draw_tags(pane.tags, ImVec2(start, area.corner.y), ImVec2(wide, area.size.y))
        if is_not_live(state.live):
            _draw_rim(area)
        _draw_line(area, x)
        if crosses:
            _cross_at(imgui.get_mouse_pos())
        _draw_readout(state, (left, right), area, covered)
    return pointer


def frame_text(request: PictureRequest, *, short: bool) -> str:
    """Which frame is asked for, counted from 1, as people do; unless `short` also its name."""
    name = request.clip.labels[request.frame_index]
    if request.clip.format == LIVE:
        return name
    place = f"{request.frame_index + 1} / {len(request.clip)}"
    return place if short or name.isdigit() else f"{place}   {in_one_line(name)}"


def _button(state: AppState, name: str, image: ByteImage, area: Area) -> Pointer | None:
    """The whole pane as a control to zoom and pan with; where in the picture the mouse is."""
    imgui.invisible_button(name, area.size, PANE_BUTTONS)
    _look_around(state, image, area)
    presenting.draw(state, "left", "right")
    if not imgui.is_item_hovered():
        return None
    presenting.point(state, _pane_at(state, name, area), clicked=imgui.is_item_clicked())
    x, y = _placement(state, image, area).picture_at(*area.mouse())
    inside = 0 <= x < image.shape[1] and 0 <= y < image.shape[0]
    return (int(x), int(y)) if inside else None


def _draws_mask_here(state: AppState) -> bool:
    """A box or a circle is asked for, and the pointer is on the pane, which is the item before."""
    return bool(state.picture.mask_tool) and imgui.is_item_hovered()


def _pane_at(state: AppState, name: str, area: Area) -> Side:
    """The side that is under the pointer, also where one pane is for both."""
    now = state.comparing.chosen
    if name == "wipe":
        return "left" if area.mouse()[0] < now.wipe * area.size.x else "right"
    return "left" if name == "left" or (name == "single" and now.flipped) else "right"


def _placement(state: AppState, image: ByteImage, area: Area) -> Placement:
    return state.picture.view.place((image.shape[1], image.shape[0]), area.inside)


def _look_around(state: AppState, image: ByteImage, area: Area) -> None:
    """Wheel zooms at the pointer or sizes the brush, drag moves, a double click fits: on both panes alike."""
    picture, pane = (image.shape[1], image.shape[0]), area.inside
    if imgui.is_item_hovered():
        if not size_by_wheel(state):
            zoom_by_wheel(state.picture, picture, area)
        if imgui.is_mouse_double_clicked(imgui.MouseButton_.left) and not state.masking.active:
            picture_actions.fit(state.picture)
            return
    by = dragged()
    if state.picture.mask_tool:
        _draw_mask(state, image, area)
    elif state.masking.active and not imgui.is_mouse_down(imgui.MouseButton_.right):
        follow_brush(state, _placement(state, image, area), area)
    elif imgui.is_item_active():
        imgui.set_mouse_cursor(imgui.MouseCursor_.hand)
        if by.x or by.y:
            picture_actions.pan(state.picture, (by.x, by.y), picture, pane)
    zoom = state.picture.view.place(picture, pane).zoom
    laid_out.size_picture(state, imgui.get_io().display_framebuffer_scale.x * zoom)


def zoom_by_wheel(seen: Seen, picture: tuple[int, int], area: Area) -> None:
    """At the pointer, which is on the item before."""
    imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
    if wheel := imgui.get_io().mouse_wheel:
        picture_actions.zoom(seen, WHEEL_STEP**wheel, area.mouse(), picture, area.inside)


def _draw_mask(state: AppState, image: ByteImage, area: Area) -> None:
    """A drag draws the box or the circle that was asked for."""
    at = _placement(state, image, area).picture_at(*area.mouse())
    if imgui.is_item_activated():
        clip_actions.begin_mask(state, at)
    if imgui.is_item_active() and state.picture.mask_start is not None and at != state.picture.mask_start:
        tool, start, aspect = (
            state.picture.mask_tool,
            state.picture.mask_start,
            state.picture.view.pixel_aspect,
        )
        mask = state.source.part.mask.drawn(tool, start, at, aspect)
        clip_actions.set_mask(state, mask)
    # Escape takes the mouse from the pane while the button is still held: it keeps no mask.
    if imgui.is_item_deactivated() and not imgui.is_mouse_down(imgui.MouseButton_.left):
        clip_actions.finish_mask(state)


def _draw_image(state: AppState, textures: ShowsPictures, slot: str, pane: Pane, area: Area) -> None:
    view = state.picture.view.scaled(imgui.get_io().display_framebuffer_scale.x)
    draw_part(textures, slot, pane.image, view, area, (pane.zebra, pane.tint))


def draw_part(
    textures: ShowsPictures, slot: str, image: ByteImage, view: PictureView, area: Area, marks: Marks = PLAIN
) -> None:
    """In whole pixels of the screen, which `view` counts, and which a window may count in larger units."""
    scale, low, high = imgui.get_io().display_framebuffer_scale.x, area.end, area.end
    pane = (area.size.x * scale, area.size.y * scale)
    place = view.place((image.shape[1], image.shape[0]), pane)
    shown = textures.part(slot, image, place, pane, marks)
    if shown is not None:
        low = ImVec2(round(area.corner.x) + shown.x / scale, round(area.corner.y) + shown.y / scale)
        high = low + ImVec2(shown.width / scale, shown.height / scale)
        textures.lay(shown, low, high)
    fill_around(area, low, high, theme.SURROUND)


def _draw_rim(area: Area) -> None:
    """Around a picture of a live source that is not of this moment: seen from across the room."""
    ink, width = imgui.get_color_u32(theme.TAG_CAUTION), em(0.35)
    half = ImVec2(width / 2, width / 2)
    imgui.get_window_draw_list().add_rect(area.corner + half, area.end - half, ink, 0, width)


def _draw_tags(tags: Sequence[Tag], corner: ImVec2, size: ImVec2) -> None:
    """In a low pane without how the image was made, which would hide it and stands in the panel beside it."""
    low = size.y < em(LOW)
    said = [one for place, one in enumerate(tags) if not low or place == 0 or one.tone != "plain"]
    stack_tags(said, corner, size.x)


def _draw_readout(state: AppState, panes: Sequence[Pane], area: Area, covered: float) -> None:
    """At the bottom: the frame, and above it the values of the pixel under the pointer."""
    assert state.picture.pictures is not None
    short = area.size.x < em(NARROW)
    lines = _values(panes, state.picture.pointer, short=short)
    lines.append(frame_text(state.picture.pictures.request, short=short))
    y, room = area.end.y - covered - em(0.26), area.size.x - em(0.8)
    for line in reversed(lines):
        y -= tag_height(line, room) + em(0.14)
        tag(line, ImVec2(area.corner.x + em(0.4), y), theme.TAG_ORIGINAL, room)


def _values(panes: Sequence[Pane], at: Pointer | None, *, short: bool) -> list[str]:
    """What the pixel is in each picture; one line for one pane, `short`: of its colour alone."""
    if at is None:
        return []
    pixels = [(pane.tags[0].text.split(" · ")[0], pixel(pane.image, at)) for pane in panes]
    said = [(_spoken(name), str(one)) for name, one in pixels if one is not None]
    place = f"x {at[0]}   y {at[1]}"
    if short and len(panes) == 1:
        return [one.color for _, one in pixels if one is not None]
    if len(panes) == 1:
        return ["   ".join((place, *(values for _, values in said)))]
    return [place, *(f"{name}   {values}" for name, values in said)]


def _spoken(name: str) -> str:
    """A tag's words without their shout; the name of a method keeps its capitals."""
    _, shouted, method = name.partition("METHOD ")
    return f"Method {method}" if shouted else name.capitalize()


def _draw_cross(state: AppState, image: ByteImage, area: Area) -> None:
    """Where the pointer of the other pane is in this one."""
    if state.picture.pointer is None:
        return
    place = _placement(state, image, area)
    column, row = state.picture.pointer
    _cross_at(area.corner + place.pane_at(column + 0.5, row + 0.5))


def _cross_at(at: ImVec2) -> None:
    draw = imgui.get_window_draw_list()
    for color, weight in ((theme.grey(0.0, 0.8), 3.0), (theme.grey(1.0), 1.0)):
        for reach in ((em(0.5), 0), (0, em(0.5))):
            draw.add_line(at - reach, at + reach, imgui.get_color_u32(color), weight)


def _drag_line(state: AppState, area: Area) -> float:
    """The line as a control over the pane; its place on the screen. A double click centres it."""
    reach = em(0.6)
    x = area.corner.x + state.comparing.chosen.wipe * area.size.x
    imgui.set_cursor_screen_pos(ImVec2(x - reach, area.corner.y))
    imgui.invisible_button("line", ImVec2(2 * reach, area.size.y))
    if imgui.is_item_hovered() or imgui.is_item_active():
        imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew)
    if imgui.is_item_hovered() and imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
        comparing.set_wipe(state, 0.5)
    elif imgui.is_item_active() and imgui.get_io().mouse_delta.x:
        comparing.set_wipe(state, area.mouse()[0] / area.size.x)
    return area.corner.x + state.comparing.chosen.wipe * area.size.x


def _draw_line(area: Area, x: float) -> None:
    draw, middle = imgui.get_window_draw_list(), area.corner.y + area.size.y / 2
    ink, ground = imgui.get_color_u32(theme.grey(0.95)), imgui.get_color_u32(theme.grey(0.1, 0.9))
    draw.add_line(ImVec2(x, area.corner.y), ImVec2(x, area.end.y), ground, em(0.22))
    draw.add_line(ImVec2(x, area.corner.y), ImVec2(x, area.end.y), ink, em(0.1))
    draw.add_circle_filled(ImVec2(x, middle), em(0.75), ground)
    draw.add_circle(ImVec2(x, middle), em(0.75), ink, 0, em(0.1))
    for way in (-1, 1):
        tip, foot = ImVec2(x + way * em(0.48), middle), x + way * em(0.16)
        draw.add_triangle_filled(tip, ImVec2(foot, middle - em(0.26)), ImVec2(foot, middle + em(0.26)), ink)
