"""The tuning grid: what to vary, the images with their measures, and one of them as it is."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

from imgui_bundle import ImVec2, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons

from app.enhancement.contact_sheet import in_words
from app.enhancement.methods import EnhancementSettings
from app.enhancement.parameter_grid import DEFINITIONS, METRICS, SMALLER_IS_BETTER, Setting
from app.enhancement.settable import MOST_VALUES
from app.gui.actions import tuning_actions
from app.gui.drawing.textures import ShowsPictures
from app.gui.panels.enhancement import VESSEL_SLIDERS
from app.gui.session_file import Choice
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.style.widgets import beside_of, button, centered, declared, em, explain, tag
from app.gui.work.tuning import GridCell
from enhance import EnhanceParams
from renderer.clip import ByteImage

NAMES: dict[bool, tuple[str, ...]] = {
    True: ("z", "p", "d_factor", "eps", "subsample"),
    False: tuple(VESSEL_SLIDERS),
}
"""What can be varied, of the paper's method and of the own preset."""
LABELS = {
    **VESSEL_SLIDERS,
    "z": "Brightness z",
    "p": "Detail P",
    "eps": "Smoothing",
    "subsample": "Subsample",
}
"""As the panel Enhancement names them."""
METRIC_LABELS = {
    "dv": "DV",
    "bv": "BV",
    "dv_bv": "DV/BV",
    "vessel_contrast": "Vessel contrast",
    "noise_gain": "Noise gain",
    "saturated_share": "Saturated share",
    "milliseconds": "Milliseconds",
    "color_difference": "Colour difference",
    "chroma_noise_gain": "Chroma noise gain",
}
SORT_LABELS = ["As varied", *(METRIC_LABELS.get(name, name) for name in METRICS)]


class ShowsTiles(ShowsPictures, Protocol):
    """Textures, for small pictures too."""

    def whole(self, slot: str, image: ByteImage) -> imgui.ImTextureRef: ...


def draw_tuning(state: AppState, textures: ShowsTiles) -> None:
    """The grid, or one of its cells as it is."""
    if state.source.clip is None:
        imgui.dummy(ImVec2(0, em(3)))
        centered("Open a clip, then try a range of settings on one of its frames.")
        return
    if state.tuning.chosen is not None:
        _draw_one(state, textures, state.tuning.chosen)
        return
    for place, choice in enumerate(state.tuning.choices):
        _draw_axis(state, place, choice)
    _draw_buttons(state)
    imgui.separator()
    if state.tuning.grid is None:
        imgui.dummy(ImVec2(0, em(2)))
        centered("Choose one or two parameters and their ranges, then press Try.")
        return
    with imgui_ctx.begin_child("tiles"):
        _draw_tiles(state, textures)


def _draw_axis(state: AppState, place: int, choice: Choice) -> None:
    names = ["", *NAMES[isinstance(state.enhancement.params, EnhanceParams)]]
    index = names.index(choice.name) if choice.name in names else 0
    imgui.set_next_item_width(em(8))
    labels = ["None", *(LABELS[name] for name in names[1:])]
    moved, index = imgui.combo(f"##vary{place}", index, labels)
    explain("The parameter of the rows." if place == 0 else "The parameter of the columns.")
    if moved:
        tuning_actions.choose_axis(
            state, place, _whole_range(type(state.enhancement.params), names[index], choice.count)
        )
        return
    if not names[index]:
        return
    about = declared(type(state.enhancement.params), names[index])
    explain(about.text)
    values = []
    for label, value in (("from", choice.first), ("to", choice.last)):
        _before(label, em(6))
        imgui.set_next_item_width(em(6))
        flags = imgui.SliderFlags_.always_clamp
        _, new = imgui.slider_float(f"##{label}{place}", value, about.lo, about.hi, "%.3g", flags)
        explain(f"{about.text} Ctrl+click: type a value.")
        values.append(round(new, 6))
    _before("in", em(6))
    imgui.set_next_item_width(em(6))
    _, count = imgui.slider_int(f"##count{place}", choice.count, 1, MOST_VALUES, "%d values")
    explain("Number of values, both ends included.")
    changed = replace(choice, first=values[0], last=values[1], count=count)
    if changed != choice:
        tuning_actions.choose_axis(state, place, changed)


def _before(word: str, width: float) -> None:
    """The word that the next control, so wide, follows."""
    beside_of(imgui.calc_text_size(word).x + em(0.5) + width)
    imgui.align_text_to_frame_padding()
    imgui.text_colored(theme.now().muted, word)
    imgui.same_line()


def _whole_range(kind: type[EnhancementSettings], name: str, count: int) -> Choice:
    """From one end of what the parameter takes to the other."""
    if not name:
        return Choice("", count=count)
    about = declared(kind, name)
    return Choice(name, about.lo, about.hi, count)


def _draw_buttons(state: AppState) -> None:
    tuning = state.tuning
    if tuning.running:
        button(f"{icons.ICON_FA_STOP}  Stop###try", lambda: tuning_actions.stop_grid(state), width=6)
        explain("Finished results are kept.")
    else:
        button(f"{icons.ICON_FA_PLAY}  Try###try", lambda: tuning_actions.start_grid(state), width=6)
        explain("Try every combination on the current frame, in the background.")
    _before("Order", em(10))
    imgui.set_next_item_width(em(10))
    index = METRICS.index(tuning.sort) + 1 if tuning.sort else 0
    _, index = imgui.combo("##order", index, SORT_LABELS)
    explain(_why(tuning.sort))
    tuning_actions.sort_by(state, METRICS[index - 1] if index else "")
    if tuning.grid is not None:
        imgui.same_line()
        imgui.text_colored(theme.now().muted, f"{len(tuning.cells)} of {len(tuning.grid.settings)}")


def _why(metric: str) -> str:
    if not metric:
        return "Sort by value, or by one measure, best first."
    end = "Smallest first." if metric in SMALLER_IS_BETTER else "Largest first."
    what = DEFINITIONS.get(metric, DEFINITIONS["dv_bv"])
    return f"{what}. {end} Visibility only, neither detection nor diagnosis."


def _draw_tiles(state: AppState, textures: ShowsTiles) -> None:
    tuning, gap = state.tuning, em(0.5)
    assert tuning.grid is not None
    columns = tuning.grid.columns if not tuning.sort else max(3, min(tuning.grid.columns, 6))
    width = max((imgui.get_content_region_avail().x - gap * (columns - 1)) / columns, em(7))
    size = tuning.grid.picture.clip.size
    height = width * size[1] / size[0]
    for place, setting in enumerate(tuning.in_order):
        if place % columns:
            imgui.same_line(0, gap)
        with imgui_ctx.begin_group():
            _draw_tile(state, textures, setting, ImVec2(width, height))


def _draw_tile(state: AppState, textures: ShowsTiles, setting: Setting, size: ImVec2) -> None:
    corner, cell = imgui.get_cursor_screen_pos(), state.tuning.cells.get(setting)
    end = ImVec2(corner.x + size.x, corner.y + size.y)
    key = "-".join(map(str, setting.places))
    if imgui.invisible_button(f"tile{key}", size) and cell is not None:
        tuning_actions.look_at(state, setting)
    explain("Click to see it at 100 %.")
    draw = imgui.get_window_draw_list()
    draw.add_rect_filled(corner, end, imgui.get_color_u32(theme.SURROUND))
    if cell is not None:
        draw.add_image(textures.whole(f"tile{key}", cell.image), corner, end)
    marked = setting.params == state.enhancement.params
    if marked or imgui.is_item_hovered() or imgui.is_item_focused():
        draw.add_rect(corner, end, imgui.get_color_u32(theme.MARK if marked else theme.INK), 0.0, 2.0)
    with imgui_ctx.push_text_wrap_pos(imgui.get_cursor_pos_x() + size.x):
        imgui.text_unformatted(said(setting))
        imgui.text_colored(theme.now().muted, in_words(cell.measures) if cell is not None else "…")


def said(setting: Setting) -> str:
    """Its values, under the names that the panels give them."""
    values = (one.partition(" ") for one in setting.label.split(" · "))
    return " · ".join(f"{LABELS.get(name, name)} {value}" for name, _, value in values)


def _draw_one(state: AppState, textures: ShowsTiles, setting: Setting) -> None:
    button(f"{icons.ICON_FA_TH}  All###back", lambda: tuning_actions.look_at(state, None), width=6)
    explain("Back to the grid.")
    imgui.same_line()
    with imgui_ctx.push_style_color(imgui.Col_.button, theme.now().lit):
        button("Use these settings###use", lambda: tuning_actions.use_setting(state, setting), width=10)
    explain("Enhance with these settings from now on. Ctrl+Z undoes it.")
    look = state.tuning.look if state.tuning.is_looked_at else None
    words = f"{said(setting)}   {in_words(look.measures) if look is not None else '…'}"
    beside_of(imgui.calc_text_size(words).x)
    imgui.align_text_to_frame_padding()
    with imgui_ctx.push_text_wrap_pos(0):
        imgui.text_unformatted(words)
    if look is not None:
        _draw_whole(state, textures, look)


def _draw_whole(state: AppState, textures: ShowsTiles, look: GridCell) -> None:
    """One pixel of the picture for one of the screen; a drag moves it."""
    corner, space = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail()
    size = ImVec2(max(space.x, em(4)), max(space.y, em(4)))
    imgui.invisible_button("whole", size)
    tuning, io = state.tuning, imgui.get_io()
    picture = (look.image.shape[1], look.image.shape[0])
    scale = io.display_framebuffer_scale.x
    pane = (size.x * scale, size.y * scale)
    if imgui.is_item_active() and (io.mouse_delta.x or io.mouse_delta.y):
        by = io.mouse_delta.x * scale, io.mouse_delta.y * scale
        tuning_actions.pan_cell(state, by, picture, pane)
    shown = textures.part("tuning", look.image, tuning.view.place(picture, pane), pane)
    end = ImVec2(corner.x + size.x, corner.y + size.y)
    draw = imgui.get_window_draw_list()
    draw.push_clip_rect(corner, end, True)
    draw.add_rect_filled(corner, end, imgui.get_color_u32(theme.SURROUND))
    if shown is not None:
        x, y = round(corner.x) + shown.x / scale, round(corner.y) + shown.y / scale
        draw.add_image(shown.texture, ImVec2(x, y), ImVec2(x + shown.width / scale, y + shown.height / scale))
    tag("ENHANCED · TRIED, 100 %", ImVec2(corner.x + em(0.4), corner.y + em(0.4)), theme.TAG_ENHANCED)
    draw.pop_clip_rect()
