"""Over the bottom of the panes: vessels that became fainter, or hardly clearer, with the way out of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from imgui_bundle import ImVec2, imgui, imgui_ctx

from app.gui.actions import enhancement_actions
from app.gui.state.app_state import AppState
from app.gui.state.panes import faint_vessels
from app.gui.style import theme
from app.gui.style.widgets import FLAT, Area, button, em, explain
from enhance import EnhanceParams, VesselParams

DIFFERENCE_TEXT = (
    "Colour difference (CIEDE2000) between the strongest dark lines of the original frame and what lies "
    "beside them. 1 is just noticeable."
)
VESSEL_TEXT = "Switch to the preset that darkens and reddens narrow dark structures as blood would."
LIFT_TEXT = "Brightening the whole image takes contrast from dark lines: set Brightening to 0."


def draw_faint_vessels(state: AppState, area: Area) -> float:
    """Over the images, which keep their place as it comes and goes; the pixels of the area's height that it
    covers. What is drawn next begins at the area's corner."""
    found = faint_vessels(state)
    if found is None:
        return 0.0
    does = "make vessels fainter" if found.are_fainter else "hardly bring out vessels"
    said = f"These settings {does} here: colour difference {found.after:.1f}, was {found.before:.1f}."
    label, act, why = _way_out(state)
    pad, frame = ImVec2(em(0.5), em(0.25)), imgui.get_style().frame_padding
    taken = imgui.calc_text_size(label).x + 2 * frame.x + em(0.5) + 2 * pad.x
    wrap = max(area.size.x - taken, em(8))
    text = imgui.calc_text_size(said, wrap_width=wrap)
    size = text + ImVec2(taken, 2 * (frame.y + pad.y))
    imgui.set_cursor_screen_pos(ImVec2(area.corner.x, area.end.y - size.y))
    kind = imgui.ChildFlags_.always_use_window_padding | FLAT
    with (
        imgui_ctx.push_style_var(imgui.StyleVar_.window_padding, pad),
        imgui_ctx.begin_child("faint vessels", size, kind),
    ):
        # A child's own ground would be below the images, which are drawn later.
        low, ground = imgui.get_window_pos(), imgui.get_color_u32(theme.TAG_CAUTION)
        imgui.get_window_draw_list().add_rect_filled(low, low + size, ground)
        imgui.align_text_to_frame_padding()
        with (
            imgui_ctx.push_text_wrap_pos(pad.x + wrap),
            imgui_ctx.push_style_color(imgui.Col_.text, theme.INK),
        ):
            imgui.text_unformatted(said)
        explain(DIFFERENCE_TEXT)
        imgui.same_line(0, em(0.5))
        button(label, act, why)
    imgui.set_cursor_screen_pos(area.corner)
    return size.y


def _way_out(state: AppState) -> tuple[str, Callable[[], object], str]:
    """A button's label, what it does, and its explanation."""
    params = state.enhancement.params
    if isinstance(params, EnhanceParams):
        return "Use Vessel", partial(enhancement_actions.choose_method, state, VesselParams), VESSEL_TEXT
    if params.lift > 0:
        plain = replace(params, lift=0.0)
        plainly = partial(enhancement_actions.use_params, state, plain, "Vessel without brightening")
        return "No brightening", plainly, LIFT_TEXT
    return (
        "Turn off",
        partial(enhancement_actions.toggle_enhancement, state),
        "E: the frame as it was recorded.",
    )
