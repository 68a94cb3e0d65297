"""How the window is started: its folder, its OpenGL, the keyboard of ImGui."""

from __future__ import annotations

import os
from pathlib import Path

import glcontext  # type: ignore[import-untyped]
import moderngl
from imgui_bundle import hello_imgui, imgui

from app.gui.work import kept_layout


def can_hold_files(folder: Path) -> bool:
    """Whether the layout can be kept there; the window opens without it too."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK)


def attach() -> moderngl.Context:
    """The window's own context; named, so that one left by an earlier window is never taken for it."""
    current = glcontext.default_backend()(mode="detect", glversion=330)
    return moderngl.create_context(require=330, context=current)


def configure(layout: Path) -> None:
    """Keyboard and docking, and the layout on disk for this screen."""
    kept_layout.fit(layout, hello_imgui.dpi_window_size_factor())
    hello_imgui.imgui_default_settings.setup_default_imgui_config()
    io = imgui.get_io()
    io.config_flags |= imgui.ConfigFlags_.nav_enable_keyboard | imgui.ConfigFlags_.docking_enable
    io.config_windows_move_from_title_bar_only = True
