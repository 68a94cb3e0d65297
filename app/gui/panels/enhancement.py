"""The parameters of the 2D enhancement; below the main ones, in tabs, the rest and what they came to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from imgui_bundle import ImVec2, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons

from app.enhancement.amounts import Amount
from app.enhancement.methods import PAPER, VESSEL, EnhancementSettings
from app.enhancement.settable import Pixels, Scope
from app.enhancement.setting_words import VESSEL_LABELS, before_strength
from app.files.legible import as_label, legible, named
from app.gui.actions import enhancement_actions, preset_actions
from app.gui.actions import history_actions as history
from app.gui.drawing.textures import ShowsPictures
from app.gui.panels.enhancement_measured import draw_curves, draw_measures
from app.gui.panels.small_picture import draw_small
from app.gui.state import scales
from app.gui.state.app_state import AppState
from app.gui.style.asking import ask, ask_name
from app.gui.style.fields import NUMBERS, amount, declared, number, slide, slide_auto, slider, with_beside
from app.gui.style.widgets import (
    FLAT,
    NAMES,
    Area,
    beside,
    beside_of,
    button,
    checkbox,
    choose_row,
    em,
    explain,
    in_line,
    mark_row,
    muted,
    row,
)
from app.gui.work.presets import BUILT_IN, preset_name
from enhance import EnhanceParams, Statistics
from enhance.vessel import VesselParams

METHODS: dict[type[EnhancementSettings], str] = {EnhanceParams: named(PAPER), VesselParams: named(VESSEL)}
LESS = 2.0
"""Em of the button that removes a window, with the gap before it."""
HEIGHT, WIDEST = 3.4, 6.0
"""Em of a small picture."""
PREPARING = "preparing"
SCOPES: dict[Scope, str] = {"automatic": "Automatic", "image": "Each frame", "clip": "Whole clip"}
PIXELS: dict[Pixels, str] = {"automatic": "Automatic", "all": "All", "tissue": "Tissue only"}
SUBSAMPLES = {1: "Off", 2: "2×", 4: "4×", 8: "8×"}
METHOD_TEXT = (
    "Paper: the published method. Vessel: VesselSplat's method, which darkens and reddens narrow dark "
    "structures as more blood would."
)
SAME_TEXT = "Use the mean of the windows' exponents P for every window."
RESET_TEXT = "R. For a single value, double click or right click its slider."
SCOPE_TEXT = (
    "Measured on each frame as in the paper, or pooled over the clip, so that playback does not flicker. "
    "Automatic: the whole clip for a recording, else each image."
)
PIXELS_TEXT = (
    "Automatic: what the endoscope sees; a dark surround is found and stays as it is. All: every pixel, "
    "as in the paper. Tissue only: every pixel, with statistics that leave out tools and black borders."
)


def draw_enhancement(state: AppState, textures: ShowsPictures) -> None:
    """Method, preset and how much of it always; all other settings, curves and measures by tab."""
    now = type(state.enhancement.params)
    chosen = choose_row("Method", now, METHODS, METHOD_TEXT)
    if chosen is not now:
        enhancement_actions.choose_method(state, chosen)
    draw_presets(state, textures)
    _change(state, slide(state.enhancement.params, "strength", "Strength"))
    _draw_edits(state)
    imgui.spacing()
    with imgui_ctx.begin_tab_bar("details") as bar:
        if bar:
            _draw_tab("Details###windows", partial(_draw_settings, state))
            _draw_tab("Curves", partial(draw_curves, state))
            _draw_tab("Measures", partial(draw_measures, state))


def draw_presets(state: AppState, textures: ShowsPictures) -> None:
    row("Preset", "Named settings. Save… stores the current ones under a name that you choose.", -4.0)
    shown = preset_name(state.enhancement.params, state.enhancement.presets)
    is_open = imgui.begin_combo("##preset", as_label(shown), imgui.ComboFlags_.height_largest)
    preset_actions.look_at(state, is_open)
    if is_open:
        for name in BUILT_IN:
            _draw_preset(state, name, shown, textures)
        if state.enhancement.presets:
            imgui.separator()
        for name in sorted(state.enhancement.presets):
            with imgui_ctx.push_id(as_label(name)):
                _draw_preset(state, name, shown, textures, beside=em(5.2))
                _draw_changes(state, name)
        if state.enhancement.preset_doomed or state.enhancement.preset_renamed:
            imgui.close_current_popup()
        imgui.end_combo()
    imgui.same_line()
    name_it = partial(imgui.open_popup, "keep preset")
    button("Save…", name_it, "Save under a name that you choose, for later sessions.", width=-1)
    with imgui_ctx.begin_popup("keep preset") as popup:
        if popup:
            _draw_keep(state)
    if doomed := state.enhancement.preset_doomed:
        said = (f"This deletes the preset {legible(doomed)} for good.",)
        if reply := ask("Delete the preset?", said, ("Delete", "Keep")):
            preset_actions.answer_forget(state, delete=reply == "Delete")
    if state.enhancement.preset_renamed:
        _draw_rename(state)


def _draw_changes(state: AppState, name: str) -> None:
    """Rename and delete an own preset, beside its line and in the middle of its height."""
    top = imgui.get_cursor_pos_y() - em(HEIGHT) - imgui.get_style().item_spacing.y
    for label, act, text in (
        (f"{icons.ICON_FA_EDIT}###rename", preset_actions.ask_rename, "Rename"),
        (f"{icons.ICON_FA_TRASH}###delete", preset_actions.ask_forget, "Delete"),
    ):
        imgui.same_line(0, em(0.5))
        imgui.set_cursor_pos_y(top + em(HEIGHT) / 2 - imgui.get_frame_height() / 2)
        button(label, partial(act, state, name), f"{text} {legible(name)}.")


def _draw_rename(state: AppState) -> None:
    take, why_not = partial(preset_actions.type_name, state), partial(preset_actions.why_not_rename, state)
    name = state.enhancement.preset_draft
    agreed = ask_name("Rename the preset", "Name of the preset", name, take, why_not, "")
    if agreed is not None:
        preset_actions.answer_rename(state, rename=agreed)


def _draw_preset(
    state: AppState, name: str, shown: str, textures: ShowsPictures, beside: float = 0.0
) -> None:
    """A line of the menu; `beside` it is room for a button."""
    chosen = _draw_thumbnail(state, name, textures)
    imgui.same_line()
    size = ImVec2(max(em(9), imgui.get_content_region_avail().x - beside), em(HEIGHT))
    with imgui_ctx.push_style_var(imgui.StyleVar_.selectable_text_align, ImVec2(0, 0.5)):
        chosen = imgui.selectable(as_label(name), name == shown, size=size)[0] or chosen
    if name == shown:
        mark_row()
    if chosen:
        preset_actions.choose(state, name)
        imgui.close_current_popup()


def _draw_thumbnail(state: AppState, name: str, textures: ShowsPictures) -> bool:
    """Room for one where it is not made yet, and why not; whether it is clicked."""
    pictures, made = state.picture.pictures, state.enhancement.thumbnails
    if pictures is None:
        imgui.dummy(ImVec2(0, em(HEIGHT)))
        return False
    area = Area.here(ImVec2(em(WIDEST), em(HEIGHT)))
    imgui.dummy(area.size)
    clicked = imgui.is_item_clicked()
    images = made.images if made is not None and made.request.pictures.original is pictures.original else {}
    waits = state.lacks(PAPER) or state.lacks(VESSEL)
    image, instead, aspect = images.get(name), PREPARING if waits else "", state.picture.view.pixel_aspect
    draw_small(textures, f"preset {name}", image, area, instead, pixel_aspect=aspect)
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
    replaced = preset_actions.replaced(state)
    pressed = button("Replace" if replaced else "Save", enabled=named)
    if replaced:
        imgui.text(f"This replaces the preset {legible(replaced)} for good.")
    # Enter alone replaces nothing: the name may have been typed without a look at the list.
    entered = pressed or (entered and not replaced)
    if entered and named:
        preset_actions.keep(state, state.enhancement.preset_draft)
        imgui.close_current_popup()


def _draw_tab(label: str, draw: Callable[[], None]) -> None:
    """Scrolled by itself, so that what is above stays in sight."""
    with imgui_ctx.begin_tab_item(label) as tab:
        if tab:
            with imgui_ctx.begin_child("content", child_flags=FLAT):
                draw()


def _draw_settings(state: AppState) -> None:
    """All but the strength, and what the automatic values are taken from."""
    params, chosen = state.enhancement.params, state.enhancement
    shown = state.picture.pictures.statistics if state.picture.pictures else None
    if isinstance(params, VesselParams):
        _change(state, _draw_vessel(params))
    elif isinstance(params, EnhanceParams):
        used = None if shown is None else before_strength(params, shown)
        _change(state, _draw_windows(_draw_paper(params, used), used))
    enhancement_actions.choose_scope(state, choose_row("Statistics", chosen.scope, SCOPES, SCOPE_TEXT))
    enhancement_actions.choose_pixels(state, choose_row("Pixels", chosen.pixels, PIXELS, PIXELS_TEXT))


def _change(state: AppState, params: EnhancementSettings) -> None:
    if params != state.enhancement.params:
        enhancement_actions.set_params(state, params)


def _draw_paper(params: EnhanceParams, used: Statistics | None) -> EnhanceParams:
    params = slide_auto(params, "z", "Brightness", used.z if used else None, 0.5)
    params = _draw_detail(params, used)
    return slide_auto(params, "d_factor", "Colour", params.k, 1.0)


def _draw_detail(params: EnhanceParams, used: Statistics | None) -> EnhanceParams:
    if not isinstance(params.p, tuple):
        p = sum(used.p) / len(used.p) if used and used.p else None
        return slide_auto(params, "p", "Detail", p, 0.5)
    text = "Each window has its own detail, the exponent P of Eq 7: see the windows below."
    row("Detail", text)
    muted("by window")
    explain(text)
    imgui.same_line()
    pressed = button("Same for all", text=SAME_TEXT, width=-1)
    return scales.together(params) if pressed else params


def _draw_vessel(params: VesselParams) -> VesselParams:
    for name, label in VESSEL_LABELS.items():
        params = slide(params, name, label, "%d px" if name == "radius" else "%.2f")
    return params


def _draw_edits(state: AppState) -> None:
    chosen = state.enhancement
    edits = (
        ("Undo", history.undo, "Ctrl+Z", len(chosen.past) > 1),
        ("Redo", history.redo, "Ctrl+Y", bool(chosen.future)),
        ("Reset all", enhancement_actions.reset_params, RESET_TEXT, enhancement_actions.can_reset(state)),
    )
    for (label, act, text, enabled), width in in_line(edits):
        button(label, partial(act, state), text, enabled=enabled, width=width)


def _draw_windows(params: EnhanceParams, used: Statistics | None) -> EnhanceParams:
    """Two rows for each window, then what all have in common."""
    exponents = scales.exponents(params, used.p if used else ())
    changed = params
    for index in range(len(params.radii)):
        with imgui_ctx.push_id(f"window {index}"):
            changed = _draw_scale(changed, index, exponents)
        if len(changed.radii) != len(params.radii):
            return changed
    changed = _draw_counts(changed)
    changed = slide(changed, "eps", "Smoothing", "%.4f", log=True)
    changed = _draw_subsample(changed)
    return slide(changed, "omit_below", "Omit below")


def _draw_scale(params: EnhanceParams, index: int, exponents: tuple[float, ...]) -> EnhanceParams:
    about, value = amount(EnhanceParams, "radii"), params.radii[index]
    draw = partial(slider, "##radius", value, about, "%d px", imgui.SliderFlags_.logarithmic)
    less = partial(_draw_less, f"{value} px", enabled=len(params.radii) > 1)
    drawn = with_beside(f"Window {index + 1}", about.text, NUMBERS + LESS, draw, less)
    (changed, radius), removed = drawn
    params = scales.with_radius(params, index, radius) if changed else params
    params = _draw_exponent(params, index, exponents)
    return scales.without_scale(params, index) if removed else params


def _draw_less(width: str, *, enabled: bool) -> bool:
    removed = button("–", text="Remove this window.", enabled=enabled, width=LESS - 0.5)
    imgui.same_line()
    number(width)
    return removed


def _draw_exponent(params: EnhanceParams, index: int, exponents: tuple[float, ...]) -> EnhanceParams:
    about, value = declared(EnhanceParams, "p"), float(exponents[index])
    shown = Amount(about.lo, about.hi, f"{about.text} Changed here, each window has its own.")
    draw = partial(slider, "##p", value, shown, "%.2f")
    said = partial(number, f"{value:.2f}", quiet=not isinstance(params.p, tuple))
    (moved, p), _ = with_beside(f"    Detail {index + 1}", shown.text, NUMBERS, draw, said)
    return scales.with_exponent(params, index, p, exponents) if moved else params


def _draw_counts(params: EnhanceParams) -> EnhanceParams:
    made, more = [params], len(params.radii) < scales.MOST_SCALES
    imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + em(NAMES))
    text = f"Add a window twice as wide; at most {scales.MOST_SCALES}."
    button("Add window", lambda: made.append(scales.with_scale(params)), text, enabled=more)
    beside("Same detail")
    together, apart = partial(scales.together, params), isinstance(params.p, tuple)
    button("Same detail", lambda: made.append(together()), SAME_TEXT, enabled=apart)
    return made[-1]


def _draw_subsample(params: EnhanceParams) -> EnhanceParams:
    about = declared(EnhanceParams, "subsample")
    now = params.subsample
    factors = SUBSAMPLES if now in SUBSAMPLES else SUBSAMPLES | {now: f"{now}×"}
    chosen = choose_row("Subsample", now, factors, about.text, 4.2)
    params = replace(params, subsample=chosen) if chosen != now else params
    beside_of(em(6.5))
    changed, keep = checkbox("Keep black", params.keep_black)
    explain(declared(EnhanceParams, "keep_black").text)
    return replace(params, keep_black=keep) if changed else params
