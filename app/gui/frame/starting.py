"""How the window is started: its folder, its OpenGL, the keyboard of ImGui."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import glcontext  # type: ignore[import-untyped]
import glfw
import moderngl
from imgui_bundle import glfw_utils, hello_imgui, imgui

from app.gui.frame.title import NAME
from app.gui.work import kept_layout

SIZE = (1280, 720)
"""The least that a first window has, and its shape on a screen that is not upright."""
ON_WIDE, ON_UPRIGHT = 0.85, 0.9
"""Of a screen, in both directions."""
LEAST = (800, 480)
"""Below which images have no room beside the panels."""


def can_hold_files(folder: Path) -> bool:
    """Whether the layout can be kept there; the window opens without it too."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK)


def why_none_opens(error: Exception) -> str:
    """One line for a window that cannot be opened; the runner tells it by the line of its own code."""
    if "glfwInit" in str(error):
        named = [
            f"{name}={os.environ[name]}" for name in ("WAYLAND_DISPLAY", "DISPLAY") if os.environ.get(name)
        ]
        got = f"none that opens ({', '.join(named)})" if named else "none that opens"
    elif str(error).startswith("IM_ASSERT"):
        got = "one without"
    else:
        got = f"an error: {error}"
    return f"expected a display with OpenGL 3.3 for the window, got {got}"


def attach() -> moderngl.Context:
    """The window's own context; named, so that one left by an earlier window is never taken for it."""
    current = glcontext.default_backend()(mode="detect", glversion=330)
    return moderngl.create_context(require=330, context=current)


def connect(drop: Callable[[object, list[str]], None]) -> None:
    """The system's window: how small it can be made, and what takes files that are dropped on it."""
    window, factor = glfw_utils.glfw_window_hello_imgui(), hello_imgui.dpi_window_size_factor()
    width, height = (round(factor * side) for side in LEAST)
    glfw.set_window_size_limits(window, width, height, glfw.DONT_CARE, glfw.DONT_CARE)
    glfw.set_drop_callback(window, drop)  # type: ignore[arg-type]


def configure(layout: Path) -> None:
    """Keyboard and docking, and the layout on disk for this screen."""
    kept_layout.fit(layout, hello_imgui.dpi_window_size_factor())
    hello_imgui.imgui_default_settings.setup_default_imgui_config()
    io = imgui.get_io()
    io.config_flags |= imgui.ConfigFlags_.nav_enable_keyboard | imgui.ConfigFlags_.docking_enable
    io.config_windows_move_from_title_bar_only = True


def _first_screen() -> Any:
    """None where there is none, or the system itself sees to its density."""
    if sys.platform == "darwin" or not glfw.init() or not glfw.get_monitors():
        return None
    return glfw.get_primary_monitor()


def _density() -> float:
    """Of the first screen, as the runner counts it."""
    screen = _first_screen()
    return 1.0 if screen is None else float(glfw.get_monitor_content_scale(screen)[0])


def _first_size() -> tuple[int, int]:
    """Of a window that none was before."""
    if (screen := _first_screen()) is None:
        return SIZE
    *_, width, height = glfw.get_monitor_workarea(screen)
    density = _density()  # The runner makes the window larger for a dense screen.
    if width <= height:
        return round(ON_UPRIGHT * width / density), round(ON_UPRIGHT * height / density)
    scale = max(ON_WIDE * min(width / SIZE[0], height / SIZE[1]) / density, 1.0)
    return round(scale * SIZE[0]), round(scale * SIZE[1])


def _short(folder: Path) -> Path:
    """By its short name on Windows where the long one has other letters than English: the runner opens no
    file by such a name there, and says nothing."""
    if sys.platform != "win32" or str(folder).isascii():
        return folder
    name = ctypes.create_unicode_buffer(260)
    ctypes.windll.kernel32.GetShortPathNameW(str(folder), name, len(name))
    return Path(name.value or folder)


def runner(layout_file: Path, *, readable: bool) -> hello_imgui.RunnerParams:
    """One window with all panels docked in it, on OpenGL 3.3; `readable`: the layout on disk counts."""
    if readable:
        # Before the runner fits the window of a denser screen into this one, and then makes it smaller still.
        kept_layout.fit(layout_file, _density())
    params = hello_imgui.RunnerParams()
    params.app_window_params.window_title = NAME
    params.app_window_params.window_geometry.size = _first_size()
    params.app_window_params.restore_previous_geometry = True
    window = params.imgui_window_params
    window.default_imgui_window_type = hello_imgui.DefaultImGuiWindowType.provide_full_screen_dock_space
    window.show_menu_bar = window.show_status_bar = True
    window.show_menu_app = window.show_menu_view = window.show_menu_view_themes = False
    window.show_status_fps = window.remember_status_bar_settings = window.remember_theme = False
    params.ini_folder_type = hello_imgui.IniFolderType.absolute_path
    params.ini_filename = str(_short(layout_file.parent) / layout_file.name)
    params.ini_disable = not readable
    gl = params.renderer_backend_options.open_gl_options
    gl.major_version, gl.minor_version, gl.anti_aliasing_samples = 3, 3, 0
    gl.use_core_profile = gl.use_forward_compat = True
    gl.glsl_version = "150"
    return params
