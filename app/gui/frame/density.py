"""The window on a screen of another density than that on which it was opened."""

from __future__ import annotations

import glfw
from imgui_bundle import glfw_utils, imgui


class Density:
    """The runner asks for the density of a screen only when the window is opened."""

    def __init__(self) -> None:
        self._first = 0.0

    def follow(self) -> float:
        """How many times as dense the screen is as the first one; 1 where the system itself enlarges what is
        drawn, as on macOS and Wayland, whose windows have more pixels than they count."""
        now = float(glfw.get_window_content_scale(glfw_utils.glfw_window_hello_imgui())[0])
        if now <= 0 or not counts_pixels():
            return 1.0
        self._first = self._first or now
        return now / self._first


def counts_pixels() -> bool:
    """Whether the window's units are pixels of the screen."""
    scale: float = imgui.get_io().display_framebuffer_scale.x
    return scale == 1
