"""What the runner does with panels and with the window when it is asked to."""

from __future__ import annotations

from imgui_bundle import hello_imgui

from app.gui.panels.editing import PANEL as EDIT
from app.gui.state import AppState

SPLATS = "Splats"
"""The 3D view of a model without pictures, in their place."""
TUNING, REPORT = "Tuning", "Report"


def toggle(name: str) -> None:
    """Show the panel, in front, or hide it."""
    panel = _docking().dockable_window_of_name(name)
    panel.is_visible = not panel.is_visible
    panel.focus_window_at_next_frame = panel.is_visible


def is_shown(name: str) -> bool:
    return bool(_docking().dockable_window_of_name(name).is_visible)


def restore() -> None:
    """Every panel back to where it was at the very start."""
    _docking().layout_reset = True


def quit_app() -> None:
    hello_imgui.get_runner_params().app_shall_exit = True


def follow(state: AppState) -> None:
    """What has nothing to show leaves its space to the other; what is asked for comes to the front."""
    panel = _docking().dockable_window_of_name
    alone = state.is_model_alone
    panel("3D view").is_visible = state.has_view and not alone
    panel("Pictures").is_visible, panel(SPLATS).is_visible = not alone, alone
    _show(panel(TUNING), state.tuning.shown)
    _show(panel(EDIT), state.editing.active)
    if state.report_asked:
        # Once in front, it is as the View menu says.
        panel(REPORT).is_visible = panel(REPORT).focus_window_at_next_frame = True
        state.report_asked = False


def _show(window: hello_imgui.DockableWindow, wanted: bool) -> None:
    """In front when it appears."""
    window.focus_window_at_next_frame |= wanted and not window.is_visible
    window.is_visible = wanted


def _docking() -> hello_imgui.DockingParams:
    return hello_imgui.get_runner_params().docking_params
