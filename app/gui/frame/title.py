"""The title of the window: what is open, and whether it is saved."""

from __future__ import annotations

import glfw
from imgui_bundle import glfw_utils

from app.files.legible import in_one_line
from app.gui.state.app_state import AppState

NAME = "VesselSplat"


def title_of(state: AppState) -> str:
    """The session or what else is open, of runs the one that is seen; a star for changes that its file does
    not have."""
    model, source = state.scene.model, state.source
    seen = model.path if model is not None and source.content == "run" else None
    path = state.session.path or seen or source.path
    if path is None:
        return NAME
    return f"{in_one_line(path.name)}{'*' if state.session.is_unsaved else ''} - {NAME}"


class Title:
    """Told to the system only when it has changed."""

    def __init__(self) -> None:
        self._shown = NAME

    def follow(self, state: AppState) -> None:
        title = title_of(state)
        if title != self._shown:
            glfw.set_window_title(glfw_utils.glfw_window_hello_imgui(), title)
            self._shown = title
