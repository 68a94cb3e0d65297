"""One line above the pictures where the enhancement makes vessels fainter, with the way out of it."""

from __future__ import annotations

from imgui_bundle import imgui

from app.enhancement.methods import preset_of
from app.files.legible import named
from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.state.panes import fainter
from app.gui.style import theme
from app.gui.style.widgets import beside, button, explain
from enhance import EnhanceParams, VesselParams

TEXT = (
    "Colour difference (CIEDE2000) between the strongest dark lines of the original frame and what lies "
    "beside them. 1 is just noticeable."
)


def draw_fainter(state: AppState) -> None:
    found = fainter(state)
    if found is None:
        return
    params = state.enhancement.params
    imgui.align_text_to_frame_padding()
    name, now = named(preset_of(params)), f"{found.after:.1f}, was {found.before:.1f}"
    imgui.text_colored(theme.now().warning, f"{name} makes vessels fainter here: {now}.")
    explain(TEXT)
    if isinstance(params, EnhanceParams):
        beside("Use Vessel")
        button("Use Vessel", lambda: actions.choose_method(state, VesselParams))
        explain("Switch to the preset that darkens and reddens narrow dark structures as blood would.")
