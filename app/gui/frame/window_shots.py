"""The whole window read from its framebuffer, on request."""

from __future__ import annotations

import glfw
import moderngl
import numpy as np
from imgui_bundle import glfw_utils

from app.gui.actions import export_actions, window_actions
from app.gui.state.app_state import AppState
from renderer.clip import ByteImage


def shoot_window(ctx: moderngl.Context, state: AppState) -> None:
    """Once a frame, when it has been drawn and not yet shown: has written what it reads."""
    if window_actions.is_due(state):
        export_actions.ask_image(state, window_actions.window_request(state, read_window(ctx)))


def read_window(ctx: moderngl.Context) -> ByteImage:
    """(H, W, 3), what is drawn and not yet shown."""
    width, height = glfw.get_framebuffer_size(glfw_utils.glfw_window_hello_imgui())
    content = ctx.detect_framebuffer(0).read(viewport=(0, 0, width, height), components=3, alignment=1)
    return np.ascontiguousarray(np.frombuffer(content, np.uint8).reshape(height, width, 3)[::-1])
