"""The tuning grid: what to vary, the images with their measures, and one of them beside the original."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from imgui_bundle import ImVec2, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons

from app.enhancement.amounts import Amount
from app.enhancement.measures import DEFINITIONS, SMALLER_IS_BETTER, Measures
from app.enhancement.methods import EnhancementSettings
from app.enhancement.parameter_grid import Setting
from app.enhancement.settable import MOST_VALUES, ORIGINAL
from app.enhancement.setting_words import LABELS, VESSEL_LABELS, in_the_paper, said
from app.gui.actions import laid_out, picture_actions, tuning_actions
from app.gui.drawing.textures import ShowsPictures
from app.gui.panels.enhancement_measured import measure_text
from app.gui.panels.overlays import make_room
from app.gui.panels.picture_pane import draw_part, frame_text, zoom_by_wheel
from app.gui.session_file import Choice
from app.gui.state.app_state import AppState
from app.gui.state.panes import original_tag, source_label
from app.gui.state.tags import Tag
from app.gui.style import theme
from app.gui.style.fields import amount
from app.gui.style.labels import stack_tags
from app.gui.style.widgets import (
    FLAT,
    Area,
    beside,
    beside_of,
    button,
    centered,
    choose,
    dragged,
    em,
    explain,
    muted,
    note,
)
from app.gui.work.tuning import GridCell
from enhance import EnhanceParams, VesselParams
from renderer.clip import ByteImage

NAMES: dict[type[EnhancementSettings], tuple[str, ...]] = {
    EnhanceParams: ("strength", "z", "p", "d_factor", "eps", "subsample"),
    VesselParams: ("strength", *VESSEL_LABELS),
}
"""What can be varied, of the paper's method and of VesselSplat's preset."""
METRIC_LABELS = {
    "vessel_contrast": "Vessel contrast", "color_difference": "Colour difference",
    "noise_gain": "Noise gain", "chroma_noise_gain": "Chroma noise gain",
    "saturated_share": "Saturated share", "milliseconds": "Milliseconds",
    "dv_bv": "DV/BV", "dv": "DV", "bv": "BV",
}  # fmt: skip
"""Those that say what is seen come first, the paper's last."""
DRAG_TEXT = "Drag, or double click to type."
SLOW = 0.05
"""Values for each pixel that a field is dragged."""
SORT_LABELS = {"": "As varied"} | METRIC_LABELS
SWEEP = "Save as sweep"
SWEEP_TEXT = (
    "A file for vesselsplat sweep, which tries these values on frames of the whole clip and measures them. "
    "Its command is in the Log: click it to copy."
)
SIZE_STEP = 1.25
LEAST_TILE = 6.0
"""Em across, unless made smaller."""
UNBROKEN = "\N{NO-BREAK SPACE}"
WORDS = 5
"""Lines below a tile, as far as they can be told before."""


def draw_tuning(state: AppState, textures: ShowsPictures) -> None:
    """The grid, or one of its cells beside the original."""
    laid_out.see_tuning(state)
    make_room(state)
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
    _draw_tiles(state, textures)


def _draw_axis(state: AppState, place: int, choice: Choice) -> None:
    kind = type(state.enhancement.params)
    names = {"": "Nothing" if place == 0 else "Nothing else"} | {name: LABELS[name] for name in NAMES[kind]}
    text = "The parameter of the rows." if place == 0 else "The parameter of the columns."
    now = choice.name if choice.name in names else ""
    name = choose(f"vary{place}", now, names, text, 8)
    if name != now:
        whole = Choice("", count=choice.count)
        if name:
            shown = amount(kind, name)
            first, last = shown.to_parameter(shown.lo), shown.to_parameter(shown.hi)
            whole = Choice(name, first, last, choice.count)
        tuning_actions.choose_axis(state, place, whole)
        return
    if not name:
        return
    shown = amount(kind, name)
    explain(shown.text)
    first = _draw_end(f"from##{place}", choice.first, shown)
    last = _draw_end(f"to##{place}", choice.last, shown)
    _before("in", em(6))
    imgui.set_next_item_width(em(6))
    flags = imgui.SliderFlags_.always_clamp
    _, count = imgui.drag_int(f"##count{place}", choice.count, SLOW, 1, MOST_VALUES, "%d values", flags)
    _point_out(f"Number of values, both ends included. {DRAG_TEXT}")
    changed = replace(choice, first=first, last=last, count=count)
    if changed != choice:
        tuning_actions.choose_axis(state, place, changed)


def _draw_end(label: str, value: float, shown: Amount) -> float:
    """Of a range of values: shown as an amount, given and returned as the parameter."""
    _before(label.partition("##")[0], em(6))
    imgui.set_next_item_width(em(6))
    now, flags = shown.of_parameter(value), imgui.SliderFlags_.always_clamp
    form = "%.2f" if shown.symbol else "%.3g"
    speed = SLOW * (shown.hi - shown.lo) / 10
    changed, new = imgui.drag_float(f"##{label}", now, speed, shown.lo, shown.hi, form, flags)
    _point_out(f"{shown.explained(value)} {DRAG_TEXT}")
    return round(shown.to_parameter(round(new, 6)), 6) if changed else value


def _point_out(text: str) -> None:
    """The field before can be dragged; without a handle, which would cover its number."""
    if imgui.is_item_hovered() or imgui.is_item_active():
        imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew)
    explain(text)


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
    beside(SWEEP)
    reason = "A frame of a live source is in no file." if state.source.is_live_frame else ""
    button(SWEEP, partial(tuning_actions.save_sweep, state), SWEEP_TEXT, reason=reason)
    _before("Order", em(10))
    tuning_actions.sort_by(state, choose("order", tuning.sort, SORT_LABELS, _why(tuning.sort), 10))
    if tuning.grid is not None:
        _draw_size(state)
        imgui.same_line(0, em(1))
        muted(f"{len(tuning.cells)} of {len(tuning.grid.settings)}")


def _draw_size(state: AppState) -> None:
    size, (least, most) = state.tuning.size, (tuning_actions.LEAST_SIZE, tuning_actions.MOST_SIZE)
    _before("Size", em(8))
    for label, step, enabled, text in (
        ("-", 1 / SIZE_STEP, size > least, "Smaller tiles."),
        ("+", SIZE_STEP, size < most, "Larger tiles."),
    ):
        resize = partial(tuning_actions.resize_tiles, state, size * step)
        button(f"{label}##size", resize, text, enabled=enabled, width=1.8)
        imgui.same_line(0, em(0.2))
    button(f"{100 * size:.0f} %###whole size", partial(tuning_actions.resize_tiles, state, 1.0),
           "All columns and whole images in sight.", width=4)  # fmt: skip


def _why(metric: str) -> str:
    if not metric:
        return "Sort by value, or by one measure, best first."
    end = "Smallest first." if metric in SMALLER_IS_BETTER else "Largest first."
    what = DEFINITIONS.get(metric, DEFINITIONS["dv_bv"])
    return f"{what}. {end} Visibility only, neither detection nor diagnosis."


def _draw_tiles(state: AppState, textures: ShowsPictures) -> None:
    """The original stays in sight at the left while the others are scrolled."""
    tuning, gap = state.tuning, em(0.5)
    assert tuning.grid is not None
    size = _tile_size(state, gap)
    with imgui_ctx.begin_group():
        _draw_original(state, textures, size)
    imgui.same_line(0, gap)
    with imgui_ctx.begin_child("tiles", ImVec2(0, 0), FLAT, imgui.WindowFlags_.horizontal_scrollbar):
        # One pixel more: windows have whole ones.
        whole = int((imgui.get_content_region_avail().x + 1 + gap) / (size.x + gap))
        laid_out.place_tiles(state, max(whole, 1) if tuning.flows else tuning.grid.columns)
        for place, setting in enumerate(tuning.in_order):
            if place % tuning.columns:
                imgui.same_line(0, gap)
            with imgui_ctx.begin_group():
                _draw_tile(state, textures, setting, size)


def _tile_size(state: AppState, gap: float) -> ImVec2:
    """With which all columns and, below an upright frame, its words are in sight."""
    tuning = state.tuning
    assert tuning.grid is not None
    fitting = tuning.grid.columns if not tuning.sort else max(3, min(tuning.grid.columns, 6))
    room, (across, down) = imgui.get_content_region_avail(), tuning.grid.picture.clip.size
    wide = (room.x - imgui.get_style().scrollbar_size - gap * fitting) / (fitting + 1)
    upright = down / (across * state.picture.view.pixel_aspect)
    high = room.y - WORDS * imgui.get_text_line_height_with_spacing()
    width = tuning.size * max(min(wide, high / upright), em(LEAST_TILE))
    return ImVec2(width, width * upright)


def _draw_original(state: AppState, textures: ShowsPictures, size: ImVec2) -> None:
    """With the first image that is tried comes the frame as recorded."""
    area, cell = Area.here(size), next(iter(state.tuning.cells.values()), None)
    imgui.dummy(size)
    explain("The frame as recorded.")
    imgui.get_window_draw_list().add_rect_filled(area.corner, area.end, imgui.get_color_u32(theme.SURROUND))
    if cell is not None:
        draw = imgui.get_window_draw_list()
        draw.add_image(textures.whole("tile original", cell.original), area.corner, area.end)
    before = cell.before if cell is not None else None
    measured = f"{_contrast(before)} · {_ratio(before)}" if before else "…"
    _draw_words(source_label(state, ORIGINAL), measured, size)
    frame, is_shown = _of_frame(state)
    with imgui_ctx.push_text_wrap_pos(imgui.get_cursor_pos_x() + size.x):
        imgui.text_colored(theme.now().muted if is_shown else theme.now().warning, frame)


def _of_frame(state: AppState) -> tuple[str, bool]:
    """Which frame the grid is of, and whether that is the one on screen."""
    assert state.tuning.grid is not None
    picture = state.tuning.grid.picture
    said = f"Frame {frame_text(picture, short=True)}"
    is_shown = picture.frame_index == state.timeline.shown_index
    return said if is_shown else f"{said}: not the one on screen", is_shown


def _draw_tile(state: AppState, textures: ShowsPictures, setting: Setting, size: ImVec2) -> None:
    area, cell = Area.here(size), state.tuning.cells.get(setting)
    key = "-".join(map(str, setting.places))
    if imgui.invisible_button(f"tile{key}", size) and cell is not None:
        tuning_actions.look_at(state, setting)
    explain(f"Click to see it enlarged beside the original. {in_the_paper(setting)}".rstrip())
    draw = imgui.get_window_draw_list()
    draw.add_rect_filled(area.corner, area.end, imgui.get_color_u32(theme.SURROUND))
    if cell is not None:
        draw.add_image(textures.whole(f"tile{key}", cell.image), area.corner, area.end)
    marked = state.is_set(setting)
    if marked or imgui.is_item_hovered() or imgui.is_item_focused():
        ink = imgui.get_color_u32(theme.MARK if marked else theme.INK)
        draw.add_rect(area.corner, area.end, ink, 0.0, 2.0)
    _draw_words(said(setting), in_words(cell.measures) if cell is not None else "…", size)


def _draw_words(what: str, measured: str, size: ImVec2) -> None:
    """Below a tile, no wider than that."""
    with imgui_ctx.push_text_wrap_pos(imgui.get_cursor_pos_x() + size.x):
        imgui.text_unformatted(_whole_parts(what))
        muted(_whole_parts(measured))


def _whole_parts(text: str) -> str:
    """Lines break between parts, not before a number."""
    return " · ".join(part.replace(" ", UNBROKEN) for part in text.split(" · "))


def _contrast(measures: Measures) -> str:
    return f"Contrast {measure_text(measures.vessel_contrast, '.3f')}"


def _ratio(measures: Measures) -> str:
    return f"DV/BV {measure_text(measures.dv_bv, '.3f')}"


def in_words(measures: Measures) -> str:
    """The three that tell most, what is seen first."""
    noise = measure_text(measures.noise_gain, ".2f")
    return f"{_contrast(measures)} · noise gain {noise} · {_ratio(measures)}"


def draw_use(use: Callable[[], None]) -> None:
    """A button that takes settings over."""
    text = "Enhance with these settings from now on. Ctrl+Z undoes it."
    button("Use these settings###use", use, text, color=theme.now().lit, width=11)


def _draw_one(state: AppState, textures: ShowsPictures, setting: Setting) -> None:
    back = partial(tuning_actions.look_at, state, None)
    button(f"{icons.ICON_FA_TH}  All###back", back, "Esc: back to the grid.", width=6)
    imgui.same_line()
    draw_use(partial(tuning_actions.use_setting, state, setting))
    fit = f"{icons.ICON_FA_EXPAND}  Fit"
    beside(fit, 1)
    button(
        f"{fit}###fit", partial(picture_actions.fit, state.tuning), "0 or double click: fit the whole frame."
    )
    beside("1:1")
    zoom = 1 / imgui.get_io().display_framebuffer_scale.x
    button("1:1", partial(picture_actions.one_to_one, state.tuning, zoom), "Actual pixels (1:1).")
    cell = state.tuning.cells.get(setting)
    words = f"{said(setting)}   {in_words(cell.measures) if cell is not None else '…'}"
    beside_of(imgui.calc_text_size(words).x, 1)
    imgui.align_text_to_frame_padding()
    note(words, theme.now().text)
    explain(f"{in_the_paper(setting)} Arrows: to its neighbours.".lstrip())
    if state.tuning.whole is not None and state.tuning.whole.request.grid is state.tuning.grid:
        _draw_pair(state, textures, state.tuning.whole)


def _draw_pair(state: AppState, textures: ShowsPictures, cell: GridCell) -> None:
    """The original and the cell, with one zoom and pan; the one before until the cell is there."""
    space, gap = imgui.get_content_region_avail(), em(0.3)
    size = ImVec2(max((space.x - gap) / 2, em(4)), max(space.y, em(4)))
    tags = [Tag("ENHANCED · TRIED", "enhanced"), Tag(said(cell.request.setting))]
    if not state.tuning.is_looked_at:
        tags.insert(0, Tag("UPDATING…", "caution"))
    frame, is_shown = _of_frame(state)
    of_original = [original_tag(state), Tag(frame, "plain" if is_shown else "caution")]
    _draw_half(state, textures, "original", cell.original, of_original, Area.here(size))
    imgui.same_line(0, gap)
    _draw_half(state, textures, "tried", cell.image, tags, Area.here(size))


def _draw_half(
    state: AppState,
    textures: ShowsPictures,
    name: str,
    image: ByteImage,
    tags: list[Tag],
    area: Area,
) -> None:
    imgui.invisible_button(name, area.size)
    _look_around(state, (image.shape[1], image.shape[0]), area)
    view = state.tuning.view.scaled(imgui.get_io().display_framebuffer_scale.x)
    with imgui_ctx.push_clip_rect(area.corner, area.end, True):
        draw_part(textures, f"tuning {name}", image, view, area)
        stack_tags(tags, area.corner, area.size.x)


def _look_around(state: AppState, picture: tuple[int, int], area: Area) -> None:
    """Wheel zooms at the pointer, drag moves, a double click fits: on either half, for both."""
    if imgui.is_item_hovered():
        zoom_by_wheel(state.tuning, picture, area)
        if imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
            picture_actions.fit(state.tuning)
    by = dragged()
    if by.x or by.y:
        picture_actions.pan(state.tuning, (by.x, by.y), picture, area.inside)
