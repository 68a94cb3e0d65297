"""The parameters of the 2D enhancement; below the main ones, in tabs, the rest and what they came to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import get_args

from imgui_bundle import imgui, imgui_ctx

from app.enhancement.methods import PAPER, VESSEL, EnhancementSettings
from app.enhancement.settable import PIXELS, Scope
from app.files.legible import named
from app.gui.actions import actions, history_actions, picture_actions
from app.gui.panels.enhancement_measured import UNUSED, draw_curves, draw_measures, facts_of
from app.gui.panels.enhancement_scales import draw_scales
from app.gui.panels.presets import Texture, draw_presets
from app.gui.state import scales
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.style.widgets import button, choose_row, em, explain, row, slide, slide_auto
from enhance import EnhanceParams, Statistics
from enhance.vessel import VesselParams

__all__ = ["UNUSED", "draw_enhancement", "facts_of"]

METHODS: tuple[type[EnhancementSettings], ...] = (EnhanceParams, VesselParams)
METHOD_LABELS = [named(PAPER), named(VESSEL)]
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
MAIN_VESSEL = ("strength", "radius", "lift", "d_factor")
SCOPES: tuple[Scope, ...] = get_args(Scope)
SCOPE_LABELS = ["Of each frame", "Of the whole clip"]
PIXEL_LABELS = ["Automatic", "All", "Tissue only"]


def draw_enhancement(state: AppState, texture: Texture) -> None:
    """Method, preset and the main sliders always; windows, curves and measures by tab."""
    _draw_method(state)
    draw_presets(state, texture)
    used = state.picture.pictures.statistics if state.picture.pictures else None
    _change(state, _draw_main(state.enhancement.params, used))
    _draw_edits(state)
    imgui.spacing()
    with imgui_ctx.begin_tab_bar("details") as bar:
        if not bar:
            return
        _draw_tabs(state, used)


def _draw_tabs(state: AppState, used: Statistics | None) -> None:
    first = "Windows" if isinstance(state.enhancement.params, EnhanceParams) else "More"
    _draw_tab(f"{first}###windows", partial(_draw_settings, state, used))
    _draw_tab("Curves", partial(draw_curves, state))
    _draw_tab("Measures", partial(draw_measures, state))


def _draw_tab(label: str, draw: Callable[[], None]) -> None:
    """Scrolled by itself, so that what is above stays in sight."""
    with imgui_ctx.begin_tab_item(label) as tab:
        if tab:
            with imgui_ctx.begin_child("content"):
                draw()


def _draw_settings(state: AppState, used: Statistics | None) -> None:
    _change(state, _draw_rest(state.enhancement.params, used))
    _draw_scope(state)


def _change(state: AppState, params: EnhancementSettings) -> None:
    if params != state.enhancement.params:
        actions.set_params(state, params)


def _draw_method(state: AppState) -> None:
    text = (
        "The paper's method, or VesselSplat's preset, which darkens and reddens narrow dark "
        "structures as blood would."
    )
    now = METHODS.index(type(state.enhancement.params))
    chosen = choose_row("Method", now, METHOD_LABELS, text)
    if chosen != now:
        actions.choose_method(state, METHODS[chosen])


def _draw_main(params: EnhancementSettings, used: Statistics | None) -> EnhancementSettings:
    if isinstance(params, VesselParams):
        return _draw_vessel(params, MAIN_VESSEL)
    params = slide_auto(params, "z", "Brightness z", used.z if used else None, 0.5)
    params = _draw_detail(params, used)
    return slide_auto(params, "d_factor", "Colour d", params.k, 1.0)


def _draw_detail(params: EnhanceParams, used: Statistics | None) -> EnhanceParams:
    if not isinstance(params.p, tuple):
        p = sum(used.p) / len(used.p) if used and used.p else None
        return slide_auto(params, "p", "Detail P", p, 0.5)
    text = "Each window has its own P, see Windows below."
    row("Detail P", text)
    imgui.align_text_to_frame_padding()
    imgui.text_colored(theme.now().muted, "   ".join(f"{p:.2f}" for p in params.p))
    explain(text)
    imgui.same_line()
    made: list[EnhanceParams] = []
    button("One P", lambda: made.append(scales.together(params)), width=-1.0)
    explain("Use the same P for every window.")
    return made[0] if made else params


def _draw_vessel(params: VesselParams, names: Sequence[str]) -> VesselParams:
    for name in names:
        params = slide(params, name, VESSEL_SLIDERS[name], "%d px" if name == "radius" else "%.2f")
    return params


def _draw_rest(params: EnhancementSettings, used: Statistics | None) -> EnhancementSettings:
    if isinstance(params, EnhanceParams):
        return draw_scales(params, used)
    return _draw_vessel(params, [name for name in VESSEL_SLIDERS if name not in MAIN_VESSEL])


def _draw_scope(state: AppState) -> None:
    """What the automatic values are taken from."""
    text = (
        "Measured on each frame as in the paper, or pooled over the clip, so that playback does not flicker."
    )
    chosen = state.enhancement
    scope = choose_row("Statistics", SCOPES.index(chosen.scope), SCOPE_LABELS, text)
    picture_actions.choose_scope(state, SCOPES[scope])
    text = (
        "Automatic: what the endoscope sees; a dark surround is found and stays as it is. All: every pixel, "
        "as in the paper. Tissue only: every pixel, by statistics without tools and black borders."
    )
    pixels = choose_row("Pixels", PIXELS.index(chosen.pixels), PIXEL_LABELS, text)
    picture_actions.choose_pixels(state, PIXELS[pixels])


def _draw_edits(state: AppState) -> None:
    width = (imgui.get_content_region_avail().x / em() - 1) / 3
    button("Undo", partial(history_actions.undo, state), enabled=len(state.enhancement.past) > 1, width=width)
    explain("Ctrl+Z")
    imgui.same_line(0, em(0.5))
    button("Redo", partial(history_actions.redo, state), enabled=bool(state.enhancement.future), width=width)
    explain("Ctrl+Y")
    imgui.same_line(0, em(0.5))
    changed = state.enhancement.params != type(state.enhancement.params)()
    button("Reset all", partial(actions.reset_params, state), enabled=changed, width=width)
    explain("R. For a single value, double click or right click its slider.")
