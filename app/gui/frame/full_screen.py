"""A window over the whole screen that it is on, and back to its place."""

from __future__ import annotations

from typing import Any

import glfw

Place = tuple[int, int, int, int]
"""Left, top, width and height."""


class FullScreen:
    """Where the window was before."""

    def __init__(self) -> None:
        self._before: Place | None = None

    def is_lost(self, window: Any) -> bool:
        """Whether the screen that it filled has gone: the system then makes it a window on another one."""
        return self._before is not None and not bool(glfw.get_window_monitor(window))

    def follow(self, window: Any, wanted: bool) -> None:
        """Go there or back, once; to another screen where that one has gone."""
        if self.is_lost(window):
            self._before = None
        if wanted == (self._before is not None):
            return
        if self._before is not None:
            glfw.set_window_monitor(window, None, *self._before, glfw.DONT_CARE)  # type: ignore[arg-type]
            self._before = None
            return
        place = place_of(window)
        monitor = nearest(place)
        if monitor is None:
            return
        self._before, mode = place, glfw.get_video_mode(monitor)
        glfw.set_window_monitor(window, monitor, 0, 0, mode.size.width, mode.size.height, mode.refresh_rate)


def place_of(window: Any) -> Place:
    (left, top), (width, height) = glfw.get_window_pos(window), glfw.get_window_size(window)
    return left, top, width, height


def nearest(place: Place) -> Any:
    """The screen under most of the window; None without any."""
    return max(glfw.get_monitors(), key=lambda monitor: shared(place, monitor), default=None)


def shared(place: Place, monitor: Any) -> int:
    """Pixels of the window on this screen."""
    (left, top), size = glfw.get_monitor_pos(monitor), glfw.get_video_mode(monitor).size
    across = min(place[0] + place[2], left + size.width) - max(place[0], left)
    down = min(place[1] + place[3], top + size.height) - max(place[1], top)
    return max(across, 0) * max(down, 0)
