"""The menu of presets, each beside what it makes of the frame on screen; and saving one's own."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from imgui_bundle import ImVec2, imgui, imgui_ctx

from app.files.legible import legible
from app.gui.actions import preset_actions
from app.gui.state.app_state import AppState
from app.gui.style.widgets import button, em, row
from app.gui.work.presets import BUILT_IN, preset_name
from renderer.clip import ByteImage

Texture = Callable[[str, ByteImage], imgui.ImTextureRef]
HEIGHT = 3.4
"""Em of a small picture."""
WIDEST = 6.0


def draw_presets(state: AppState, texture: Texture) -> None:
    row("Preset", "Named settings. Save stores the current ones under a name of yours.")
    imgui.set_next_item_width(-em(4.0))
    shown = preset_name(state.enhancement.params, state.enhancement.presets) or "custom"
    is_open = imgui.begin_combo("##preset", legible(shown), imgui.ComboFlags_.height_largest)
    preset_actions.look_at(state, is_open)
    if is_open:
        for name in BUILT_IN:
            _draw_preset(state, name, shown, texture)
        _draw_own(state, shown, texture)
        imgui.end_combo()
    imgui.same_line()
    name_it = partial(imgui.open_popup, "keep preset")
    button("Save…", name_it, "Save under a name of yours, for later sessions.", width=-1)
    with imgui_ctx.begin_popup("keep preset") as popup:
        if popup:
            _draw_keep(state)


def _draw_own(state: AppState, shown: str, texture: Texture) -> None:
    if state.enhancement.presets:
        imgui.separator()
    for name in sorted(state.enhancement.presets):
        with imgui_ctx.push_id(name):
            _draw_preset(state, name, shown, texture, beside=em(2))
            imgui.same_line(0, 0)
            forget = partial(preset_actions.forget, state, name)
            button("×", forget, f"Delete {legible(name)}.", small=True)


def _draw_preset(state: AppState, name: str, shown: str, texture: Texture, beside: float = 0.0) -> None:
    """A line of the menu; `beside` it is room for a button."""
    chosen = _draw_thumbnail(state, name, texture)
    imgui.same_line()
    size = ImVec2(max(em(9), imgui.get_content_region_avail().x - beside), em(HEIGHT))
    with imgui_ctx.push_style_var(imgui.StyleVar_.selectable_text_align, ImVec2(0, 0.5)):
        chosen = imgui.selectable(legible(name), name == shown, size=size)[0] or chosen
    if chosen:
        preset_actions.choose(state, name)
        imgui.close_current_popup()


def _draw_thumbnail(state: AppState, name: str, texture: Texture) -> bool:
    """Room for one where it is not made yet; whether it is clicked."""
    pictures, made = state.picture.pictures, state.enhancement.thumbnails
    if pictures is None:
        imgui.dummy(ImVec2(0, em(HEIGHT)))
        return False
    height, width = pictures.photo.shape[:2]
    scale = min(em(HEIGHT) / height, em(WIDEST) / width)
    corner, room = imgui.get_cursor_screen_pos(), ImVec2(em(WIDEST), em(HEIGHT))
    imgui.dummy(room)
    clicked = imgui.is_item_clicked()
    if made is not None and made.request.pictures.photo is pictures.photo and name in made.images:
        size = ImVec2(scale * width, scale * height)
        low, drawn = corner + (room - size) / 2, texture(f"preset {name}", made.images[name])
        imgui.get_window_draw_list().add_image(drawn, low, low + size)
    return clicked


def _draw_keep(state: AppState) -> None:
    if imgui.is_window_appearing():
        preset_actions.type_name(state, "")
        imgui.set_keyboard_focus_here()
    imgui.set_next_item_width(em(14))
    flags = imgui.InputTextFlags_.enter_returns_true
    entered, name = imgui.input_text_with_hint("##name", "name", state.enhancement.preset_draft, flags)
    preset_actions.type_name(state, name)
    imgui.same_line()
    named = bool(state.enhancement.preset_draft.strip())
    imgui.begin_disabled(not named)
    entered |= imgui.button("Save")
    imgui.end_disabled()
    if entered and named:
        preset_actions.keep(state, state.enhancement.preset_draft)
        imgui.close_current_popup()
