"""The window as a whole, as functions on the state: its image, its panels, full screen."""

from __future__ import annotations

from dataclasses import replace

from app.exports.exporting import ExportRequest
from app.exports.records import PanesPicture
from app.exports.sources import Opened
from app.gui.actions import export_actions, presenting
from app.gui.actions.export_names import default_name
from app.gui.actions.export_records import format_of
from app.gui.state.app_state import AppState
from renderer.clip import ByteImage


def toggle_panels(state: AppState) -> None:
    """The pictures alone, or all panels around them again, after a presentation too."""
    if state.presenting.pane is not None:
        presenting.leave(state)
    else:
        state.window.bare = not state.window.bare


def toggle_full_screen(state: AppState) -> None:
    state.window.full_screen = not state.window.full_screen


def is_due(state: AppState) -> bool:
    """Called once a frame when it is drawn: whether this is the frame to save."""
    if state.exports.settling == 0:
        return False
    state.exports.settling -= 1
    return state.exports.settling == 0


def window_request(state: AppState, image: ByteImage) -> ExportRequest:
    """The picture (H, W, 3) that was read, with what there was to see of panes and 3D view."""
    shown = export_actions.shown_request(state)
    record, sources = PanesPicture(), Opened()
    if shown is not None and isinstance(shown.record, PanesPicture):
        record, sources = shown.record, shown.sources
    exports = state.exports
    suffix = format_of(state, "picture")
    quality = exports.quality if suffix == ".jpg" else None
    chosen = exports.shown and exports.what == "window"
    stem = export_actions.stem_of(state) if chosen else default_name(state, "window")
    said = replace(record, kind="window", quality=quality)
    return ExportRequest(state.export_folder, stem, suffix, said, sources, image)


def note_layout(state: AppState) -> None:
    """Another layout has come, and the one before is kept."""
    state.window.layout_changes += 1


def is_reduced(state: AppState) -> bool:
    """Panels are hidden, or the window is larger than it was put."""
    return state.window.bare or state.window.full_screen or state.presenting.pane is not None


def restore(state: AppState) -> None:
    """All panels, and the window in its place."""
    presenting.leave(state)
    state.window.bare = state.window.full_screen = False
