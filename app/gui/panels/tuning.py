"""The tuning grid: what to vary, the images with their measures, and one of them as it is."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from imgui_bundle import ImVec2, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons

from app.enhancement.methods import EnhancementSettings
from app.enhancement.parameter_grid import DEFINITIONS, SMALLER_IS_BETTER, Measures, Setting
from app.enhancement.settable import MOST_VALUES
from app.gui.actions import tuning_actions
from app.gui.drawing.textures import ShowsPictures
from app.gui.panels.enhancement import VESSEL_SLIDERS
from app.gui.panels.picture_pane import draw_part
from app.gui.session_file import Choice
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.style.fields import declared
from app.gui.style.widgets import Area, beside_of, button, centered, choose, em, explain, muted, tag
from app.gui.work.tuning import GridCell
from enhance import EnhanceParams, VesselParams

NAMES: dict[type[EnhancementSettings], tuple[str, ...]] = {
    EnhanceParams: ("z", "p", "d_factor", "eps", "subsample"),
    VesselParams: tuple(VESSEL_SLIDERS),
}
"""What can be varied, of the paper's method and of the own preset."""
LABELS = VESSEL_SLIDERS | {
    "z": "Brightness z", "p": "Detail P", "d_factor": "Colour d", "eps": "Smoothing", "subsample": "Subsample"
}  # fmt: skip
"""As the panel Enhancement names them; with a letter where the values are the paper's, as in what is kept."""
METRIC_LABELS = {
    "vessel_contrast": "Vessel contrast", "color_difference": "Colour difference",
    "noise_gain": "Noise gain", "chroma_noise_gain": "Chroma noise gain",
    "saturated_share": "Saturated share", "milliseconds": "Milliseconds",
    "dv_bv": "DV/BV", "dv": "DV", "bv": "BV",
}  # fmt: skip
"""Those that say what is seen come first, the paper's last."""
SORT_LABELS = {"": "As varied"} | METRIC_LABELS


def draw_tuning(state: AppState, textures: ShowsPictures) -> None:
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
    kind = type(state.enhancement.params)
    names = {"": "None"} | {name: LABELS[name] for name in NAMES[kind]}
    text = "The parameter of the rows." if place == 0 else "The parameter of the columns."
    now = choice.name if choice.name in names else ""
    name = choose(f"vary{place}", now, names, text, 8)
    if name != now:
        whole = Choice("", count=choice.count)
        if name:
            whole = Choice(name, declared(kind, name).lo, declared(kind, name).hi, choice.count)
        tuning_actions.choose_axis(state, place, whole)
        return
    if not name:
        return
    about = declared(kind, name)
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
    muted(word)
    imgui.same_line()


def _draw_buttons(state: AppState) -> None:
    tuning, label, act = state.tuning, f"{icons.ICON_FA_PLAY}  Try", tuning_actions.start_grid
    text = "Try every combination on the current frame, in the background."
    if tuning.running:
        label, act = f"{icons.ICON_FA_STOP}  Stop", tuning_actions.stop_grid
        text = "Finished results are kept."
    button(f"{label}###try", partial(act, state), text, width=6)
    _before("Order", em(10))
    tuning_actions.sort_by(state, choose("order", tuning.sort, SORT_LABELS, _why(tuning.sort), 10))
    if tuning.grid is not None:
        imgui.same_line()
        muted(f"{len(tuning.cells)} of {len(tuning.grid.settings)}")


def _why(metric: str) -> str:
    if not metric:
        return "Sort by value, or by one measure, best first."
    end = "Smallest first." if metric in SMALLER_IS_BETTER else "Largest first."
    what = DEFINITIONS.get(metric, DEFINITIONS["dv_bv"])
    return f"{what}. {end} Visibility only, neither detection nor diagnosis."


def _draw_tiles(state: AppState, textures: ShowsPictures) -> None:
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


def _draw_tile(state: AppState, textures: ShowsPictures, setting: Setting, size: ImVec2) -> None:
    area, cell = Area.here(size), state.tuning.cells.get(setting)
    key = "-".join(map(str, setting.places))
    if imgui.invisible_button(f"tile{key}", size) and cell is not None:
        tuning_actions.look_at(state, setting)
    explain("Click to see it at 100 %.")
    draw = imgui.get_window_draw_list()
    draw.add_rect_filled(area.corner, area.end, imgui.get_color_u32(theme.SURROUND))
    if cell is not None:
        draw.add_image(textures.whole(f"tile{key}", cell.image), area.corner, area.end)
    marked = setting.params == state.enhancement.params
    if marked or imgui.is_item_hovered() or imgui.is_item_focused():
        ink = imgui.get_color_u32(theme.MARK if marked else theme.INK)
        draw.add_rect(area.corner, area.end, ink, 0.0, 2.0)
    with imgui_ctx.push_text_wrap_pos(imgui.get_cursor_pos_x() + size.x):
        imgui.text_unformatted(said(setting))
        muted(_in_words(cell.measures) if cell is not None else "…")


def said(setting: Setting) -> str:
    """Its values, under the names that the panels give them."""
    values = (one.partition(" ") for one in setting.label.split(" · "))
    return " · ".join(f"{LABELS.get(name, name)} {value}" for name, _, value in values)


def _in_words(measures: Measures) -> str:
    """The three that tell most, what is seen first."""
    contrast, noise = measures.vessel_contrast, measures.noise_gain
    return f"Contrast {contrast:.3g} · noise gain {noise:.2g} · DV/BV {measures.dv_bv:.3g}"


def _draw_one(state: AppState, textures: ShowsPictures, setting: Setting) -> None:
    back = partial(tuning_actions.look_at, state, None)
    button(f"{icons.ICON_FA_TH}  All###back", back, "Back to the grid.", width=6)
    imgui.same_line()
    text = "Enhance with these settings from now on. Ctrl+Z undoes it."
    use = partial(tuning_actions.use_setting, state, setting)
    button("Use these settings###use", use, text, color=theme.now().lit, width=10)
    look = state.tuning.look if state.tuning.is_looked_at else None
    words = f"{said(setting)}   {_in_words(look.measures) if look is not None else '…'}"
    beside_of(imgui.calc_text_size(words).x)
    imgui.align_text_to_frame_padding()
    with imgui_ctx.push_text_wrap_pos(0):
        imgui.text_unformatted(words)
    if look is not None:
        _draw_whole(state, textures, look)


def _draw_whole(state: AppState, textures: ShowsPictures, look: GridCell) -> None:
    """One pixel of the picture for one of the screen; a drag moves it."""
    space, io = imgui.get_content_region_avail(), imgui.get_io()
    area = Area.here(ImVec2(max(space.x, em(4)), max(space.y, em(4))))
    imgui.invisible_button("whole", area.size)
    by, pane = (size * io.display_framebuffer_scale.x for size in (io.mouse_delta, area.size))
    if imgui.is_item_active() and (by.x or by.y):
        picture = (look.image.shape[1], look.image.shape[0])
        tuning_actions.pan_cell(state, (by.x, by.y), picture, (pane.x, pane.y))
    with imgui_ctx.push_clip_rect(area.corner, area.end, True):
        draw_part(textures, "tuning", look.image, state.tuning.view, area)
        tag("ENHANCED · TRIED, 100 %", area.corner + ImVec2(em(0.4), em(0.4)), theme.TAG_ENHANCED)
