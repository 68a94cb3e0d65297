"""The two pictures: left always the original, right always the enhanced one, zoom and pan linked."""

from __future__ import annotations

from collections.abc import Callable

from imgui_bundle import ImVec2, ImVec4, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons

from app.gui import actions, theme
from app.gui.enhancing import Pictures
from app.gui.export import describe
from app.gui.keys import fit_pictures, one_to_one
from app.gui.state import AppState
from app.gui.textures import ShowsPictures
from app.gui.widgets import button, centered, em, explain, stack_tags, tag
from renderer.clip import ByteImage

WHEEL_STEP = 1.15
STALE_SECONDS = 0.15
"""Younger than this, an update on its way is not worth a flashing tag."""
Tag = tuple[str, ImVec4]


def draw_compare(state: AppState, textures: ShowsPictures, draw_welcome: Callable[[], None]) -> None:
    """Both pictures with their tags, or what to do when there is no clip yet."""
    if state.clip is None:
        draw_welcome()
        return
    _draw_toolbar(state)
    if state.pictures is None:
        imgui.dummy(ImVec2(0, em(4)))
        centered("Reading the first frame…")
        return
    space, gap = imgui.get_content_region_avail(), em(0.3)
    size = ImVec2(max((space.x - gap) / 2, em(4)), max(space.y, em(4)))
    left, right = state.pictures.photo, shown_enhanced(state, state.pictures)
    _draw_pane(state, textures, "original", left, original_tags(state, state.pictures), size)
    imgui.same_line(0, gap)
    _draw_pane(state, textures, "enhanced", right, enhanced_tags(state, state.pictures), size)


def _draw_toolbar(state: AppState) -> None:
    label = "Enhancement on" if state.enhancing else "Enhancement off"
    role = imgui.Col_.button
    with imgui_ctx.push_style_color(role, theme.ACCENT_DIM if state.enhancing else theme.grey(0.25)):
        button(f"{label}###enhancing", lambda: actions.toggle_enhancement(state), width=9)
    explain("E: on and off. Esc: plain white light. Hold Space: original in the enhanced pane.")
    imgui.same_line()
    freezing = state.frozen_index is not None
    with imgui_ctx.push_style_color(role, theme.TAG_CAUTION if freezing else theme.grey(0.25)):
        button("Frozen###freeze" if freezing else "Freeze###freeze", lambda: actions.toggle_freeze(state))
    explain("F: hold this frame in both pictures while time goes on.")
    imgui.same_line(0, em(1.5))
    button(f"{icons.ICON_FA_EXPAND}  Fit", lambda: fit_pictures(state))
    explain("0 or a double click: the whole picture.")
    imgui.same_line()
    button("1:1", lambda: one_to_one(state))
    explain("1: one pixel of the picture for one of the screen.")
    imgui.same_line()
    imgui.align_text_to_frame_padding()
    imgui.text_colored(theme.MUTED, f"{100 * state.zoom:.0f} %")


def shown_enhanced(state: AppState, pictures: Pictures) -> ByteImage:
    """What the enhanced pane shows: the enhanced picture, or the photo where there is none or by wish."""
    if pictures.enhanced is None or state.peeking or not state.enhancing:
        return pictures.photo
    return pictures.enhanced


def original_tags(state: AppState, pictures: Pictures) -> list[Tag]:
    """What the left pane says of itself."""
    return [("ORIGINAL", theme.TAG_ORIGINAL), *_state_tags(state, pictures)]


def enhanced_tags(state: AppState, pictures: Pictures) -> list[Tag]:
    """What the right pane says of itself; it never looks enhanced without saying so, nor the reverse."""
    if not state.enhancing:
        head: list[Tag] = [("WHITE LIGHT · enhancement off", theme.TAG_CAUTION)]
    elif state.peeking:
        head = [("ORIGINAL · peek", theme.TAG_CAUTION)]
    elif pictures.enhanced is None:
        head = [("PREPARING… original shown", theme.TAG_CAUTION)]
    else:
        head = [("ENHANCED", theme.TAG_ENHANCED), (describe(pictures), theme.TAG_ORIGINAL)]
    return [*head, *_state_tags(state, pictures)]


def _state_tags(state: AppState, pictures: Pictures) -> list[Tag]:
    tags: list[Tag] = []
    if state.frozen_index is not None:
        tags.append((f"FROZEN · frame {state.frozen_index + 1}", theme.TAG_CAUTION))
    if state.pictures_are_stale and not state.playing and state.now - state.asked_at > STALE_SECONDS:
        tags.append(("UPDATING…", theme.TAG_CAUTION))
    return tags


def frame_text(pictures: Pictures) -> str:
    """Which frame the pictures are of, counted from 1 as people do, and its name in the clip."""
    request = pictures.request
    name = request.clip.labels[request.frame_index]
    place = f"{request.frame_index + 1} / {len(request.clip)}"
    return place if name.isdigit() else f"{place}   {name}"


def _draw_pane(
    state: AppState, textures: ShowsPictures, slot: str, image: ByteImage, tags: list[Tag], size: ImVec2
) -> None:
    assert state.pictures is not None
    corner = imgui.get_cursor_screen_pos()
    flags = imgui.ButtonFlags_.mouse_button_left | imgui.ButtonFlags_.mouse_button_right
    imgui.invisible_button(slot, size, flags)
    _look_around(state, image, corner, size)
    end = ImVec2(corner.x + size.x, corner.y + size.y)
    draw = imgui.get_window_draw_list()
    draw.push_clip_rect(corner, end, True)
    draw.add_rect_filled(corner, end, imgui.get_color_u32(theme.SURROUND))
    _draw_image(state, textures, slot, image, corner, size)
    stack_tags(tags, corner)
    below = ImVec2(corner.x + em(0.4), end.y - imgui.get_text_line_height() - em(0.76))
    tag(frame_text(state.pictures), below, theme.TAG_ORIGINAL)
    draw.pop_clip_rect()


def _draw_image(
    state: AppState, textures: ShowsPictures, slot: str, image: ByteImage, corner: ImVec2, size: ImVec2
) -> None:
    """Sampled and placed in whole pixels of the screen, which a window may count in larger units."""
    scale = imgui.get_io().display_framebuffer_scale.x
    pane = (size.x * scale, size.y * scale)
    view = state.picture_view.scaled(scale)
    shown = textures.part(slot, image, view.place((image.shape[1], image.shape[0]), pane), pane)
    if shown is not None:
        x, y = round(corner.x) + shown.x / scale, round(corner.y) + shown.y / scale
        end = ImVec2(x + shown.width / scale, y + shown.height / scale)
        imgui.get_window_draw_list().add_image(shown.texture, ImVec2(x, y), end)


def _look_around(state: AppState, image: ByteImage, corner: ImVec2, size: ImVec2) -> None:
    """Wheel zooms at the pointer, drag moves, a double click fits: on either pane, for both."""
    io, picture, pane = imgui.get_io(), (image.shape[1], image.shape[0]), (size.x, size.y)
    if imgui.is_item_hovered():
        imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
        if io.mouse_wheel != 0:
            at = (io.mouse_pos.x - corner.x, io.mouse_pos.y - corner.y)
            state.picture_view = state.picture_view.zoomed(WHEEL_STEP**io.mouse_wheel, at, picture, pane)
        if imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
            fit_pictures(state)
            return
    dragged = io.mouse_delta.x != 0 or io.mouse_delta.y != 0
    if imgui.is_item_active() and dragged:
        state.picture_view = state.picture_view.panned((io.mouse_delta.x, io.mouse_delta.y), picture, pane)
    state.zoom = io.display_framebuffer_scale.x * state.picture_view.place(picture, pane).zoom
