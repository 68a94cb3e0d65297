"""The parameters of the 2D enhancement, and what they came to on the picture that is shown."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

from imgui_bundle import imgui, imgui_ctx

from app.gui import actions, theme
from app.gui.enhancing import Scope
from app.gui.state import AppState
from app.gui.widgets import button, declared, em, explain, row, slide, slide_auto, slider, wants_default
from app.methods import PAPER, VESSEL, Look
from enhance import EnhanceParams, Statistics
from enhance.vessel import VesselParams

METHODS: tuple[type[Look], ...] = (EnhanceParams, VesselParams)
METHOD_LABELS = [PAPER, VESSEL]
VESSEL_SLIDERS = {
    "strength": "Strength",
    "radius": "Radius",
    "shading": "Shading",
    "coring": "Coring",
    "lift": "Lift",
    "gamma": "Gamma",
    "d_factor": "Colour d",
    "most_color": "Most colour",
}
SUBSAMPLES = (1, 2, 4, 8)
SCOPES: tuple[Scope, ...] = get_args(Scope)
SCOPE_LABELS = ["of each frame", "of the whole clip"]
UNUSED = "unused"
SIGMA_TEXT = (
    "Eq 9: standard deviation of each window's base layer, in grey levels. "
    "Not measured of a frame while P is set by hand."
)
PIXEL_LABELS = ["all", "tissue only"]


def draw_enhancement(state: AppState) -> None:
    """The method, its sliders in the order of its stages, then what was measured."""
    _draw_method(state)
    used = state.pictures.statistics if state.pictures else None
    params = _draw_params(state.params, used)
    if params != state.params:
        actions.set_params(state, params)
    _draw_scope(state)
    imgui.spacing()
    _draw_edits(state)
    imgui.spacing()
    _draw_measured(state, used)


def _draw_method(state: AppState) -> None:
    text = "The paper's, or the own preset, which darkens and reddens narrow dark structures as blood would."
    now = METHODS.index(type(state.params))
    chosen = _choose("Method", now, METHOD_LABELS, text)
    if chosen != now:
        actions.choose_method(state, METHODS[chosen])


def _draw_params(params: Look, used: Statistics | None) -> Look:
    return _draw_paper(params, used) if isinstance(params, EnhanceParams) else _draw_vessel(params)


def _draw_paper(params: EnhanceParams, used: Statistics | None) -> EnhanceParams:
    params = _draw_strengths(params, used)
    imgui.spacing()
    return _draw_windows(params)


def _draw_vessel(params: VesselParams) -> VesselParams:
    for name, label in VESSEL_SLIDERS.items():
        params = slide(params, name, label, "%d px" if name == "radius" else "%.2f")
    return params


def _draw_strengths(params: EnhanceParams, used: Statistics | None) -> EnhanceParams:
    p = sum(used.p) / len(used.p) if used and used.p else None
    params = slide_auto(params, "z", "Brightness z", used.z if used else None, 0.5)
    params = slide_auto(params, "p", "Detail P", p, 0.5)
    return slide(params, "d_factor", "Colour d")


def _draw_windows(params: EnhanceParams) -> EnhanceParams:
    about = declared(EnhanceParams, "radii")
    row("Windows", about.text)
    radii, gap = list(params.radii), em(0.25)
    width = (imgui.get_content_region_avail().x - gap * (len(radii) - 1)) / len(radii)
    flags = imgui.SliderFlags_.always_clamp | imgui.SliderFlags_.logarithmic
    for index, radius in enumerate(params.radii):
        if index:
            imgui.same_line(0, gap)
        imgui.set_next_item_width(width)
        changed, new = slider(f"##radius{index}", radius, about, "%d px", flags)
        explain(about.text)
        radii[index] = new if changed else radius
        if wants_default(f"radius{index}"):
            radii[index] = about.default[index]
    params = replace(params, radii=tuple(radii))
    params = slide(params, "eps", "Smoothing", "%.4f", log=True)
    return _draw_subsample(params)


def _draw_subsample(params: EnhanceParams) -> EnhanceParams:
    about = declared(EnhanceParams, "subsample")
    row("Subsample", about.text)
    imgui.set_next_item_width(em(4.2))
    labels = [f"{factor}×" if factor > 1 else "off" for factor in SUBSAMPLES]
    index = SUBSAMPLES.index(params.subsample) if params.subsample in SUBSAMPLES else 1
    changed, index = imgui.combo("##subsample", index, labels)
    explain(about.text)
    params = replace(params, subsample=SUBSAMPLES[index]) if changed else params
    imgui.same_line()
    changed, keep = imgui.checkbox("keep black", params.keep_black)
    explain(declared(EnhanceParams, "keep_black").text)
    return replace(params, keep_black=keep) if changed else params


def _draw_scope(state: AppState) -> None:
    """What the automatic values are taken from."""
    text = "Of each frame as in the paper, or pooled over the clip, so that playing does not flicker."
    state.scope = SCOPES[_choose("Statistics", SCOPES.index(state.scope), SCOPE_LABELS, text)]
    text = "All as in the paper, or without tools and the black surround."
    state.tissue_only = bool(_choose("Pixels", int(state.tissue_only), PIXEL_LABELS, text))


def _choose(label: str, index: int, values: list[str], text: str) -> int:
    row(label, text)
    imgui.set_next_item_width(-em(0.1))
    _, index = imgui.combo(f"##{label}", index, values)
    explain(text)
    return index


def _draw_edits(state: AppState) -> None:
    width = (imgui.get_content_region_avail().x / em() - 1) / 3
    button("Undo", lambda: actions.undo(state), enabled=len(state.past) > 1, width=width)
    explain("Ctrl+Z")
    imgui.same_line(0, em(0.5))
    button("Redo", lambda: actions.redo(state), enabled=bool(state.future), width=width)
    explain("Ctrl+Y")
    imgui.same_line(0, em(0.5))
    changed = state.params != type(state.params)()
    button("Reset all", lambda: actions.reset_params(state), enabled=changed, width=width)
    explain("R. One value alone: double click on its slider, or right click.")


def facts_of(used: Statistics, milliseconds: float) -> tuple[tuple[str, str, str], ...]:
    """Name, value and explanation of what was measured."""
    sigmas = "  ".join(f"{sigma:.0f}" for sigma in used.sigmas) or UNUSED
    exponents = "  ".join(f"{p:.2f}" for p in dict.fromkeys(used.p))
    return (
        ("L", f"{used.level:.0f}", "Eq 2: grey level below which a tenth of the picture lies."),
        ("σ", sigmas, SIGMA_TEXT),
        ("z", f"{used.z:.3f}", "Eq 1: brightness factor in use."),
        ("P", exponents, "Eq 7: exponent in use at each window."),
        ("S mean", f"{used.saturation_mean:.3f}", "Eq 12: mean saturation."),
        ("time", f"{milliseconds:.0f} ms", "Of the enhancement of this frame, here."),
    )


def _draw_measured(state: AppState, used: Statistics | None) -> None:
    if used is None or state.pictures is None:
        imgui.text_colored(theme.MUTED, "—")
        return
    with imgui_ctx.begin_table("measured", 4) as table:
        if not table:
            return
        for column, width in enumerate((3.6, 4.5, 2.6, 4.5)):
            imgui.table_setup_column(str(column), imgui.TableColumnFlags_.width_fixed, em(width))
        for name, value, text in facts_of(used, state.pictures.milliseconds):
            imgui.table_next_column()
            imgui.text_colored(theme.MUTED, name)
            explain(text)
            imgui.table_next_column()
            if value == UNUSED:
                imgui.text_colored(theme.MUTED, value)
            else:
                imgui.text_unformatted(value)
            explain(text)
