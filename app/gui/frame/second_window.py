"""A second window, for a second monitor: one pane alone, that follows the first window's frame.

Its OpenGL context shares the textures of the first one's. What happens in it comes with the events of the
first one; it is drawn between two frames of that one, and only when it has something new to show.
"""

from __future__ import annotations

from functools import partial
from typing import Any, Final

import glfw
from imgui_bundle import glfw_utils

from app.gui.actions import actions, presenting
from app.gui.commands.command import Act
from app.gui.drawing.quads import Quad, QuadView
from app.gui.frame import starting
from app.gui.frame.full_screen import FullScreen, Place, nearest, place_of, shared
from app.gui.frame.second_content import SecondContent
from app.gui.state.app_state import AppState

SIZE: Final = (640, 480)
LOST: Final = "the monitor of the second window was disconnected: Shift+F5 opens the window again"
GAP: Final = 48
"""Pixels from the corner of the first window, on the same screen."""
HINTS: Final = {
    glfw.CONTEXT_VERSION_MAJOR: 3, glfw.CONTEXT_VERSION_MINOR: 3,
    glfw.OPENGL_PROFILE: glfw.OPENGL_CORE_PROFILE, glfw.OPENGL_FORWARD_COMPAT: True,
    glfw.SAMPLES: 0,
    # The keyboard stays with the controls, and a full screen stays when the other window is used.
    glfw.FOCUSED: False, glfw.FOCUS_ON_SHOW: False, glfw.AUTO_ICONIFY: False,
}  # fmt: skip
KEYS: Final[dict[int, Act]] = {
    glfw.KEY_1: partial(presenting.show_in_second, pane="left"),
    glfw.KEY_2: partial(presenting.show_in_second, pane="right"),
    glfw.KEY_3: partial(presenting.show_in_second, pane="3D view"),
    glfw.KEY_L: presenting.toggle_second_labels,
    glfw.KEY_F11: lambda s: presenting.fill_second(s, not s.second_window.full_screen),
    glfw.KEY_LEFT: partial(actions.step, frames=-1),
    glfw.KEY_RIGHT: partial(actions.step, frames=1),
    glfw.KEY_SPACE: actions.toggle_play,
}
"""Escape ends full screen, then the window."""
CLOSES: Final = (glfw.KEY_F5, glfw.MOD_SHIFT)
"""As it opens: the key and what is held with it."""


class SecondWindow:
    """Opened, drawn and closed as the state says."""

    def __init__(self, content: SecondContent) -> None:
        self._content, self._first = content, glfw_utils.glfw_window_hello_imgui()
        self._window: Any = None
        self._view: QuadView | None = None
        self._full_screen = FullScreen()
        self._drawn: object = None
        self._place: Place | None = None
        self._pressed: list[int] = []

    def follow(self, state: AppState) -> None:
        """After a frame of the first window, whose context is current before and after."""
        if self._window is not None:
            self._listen(state)
            self._end_without_monitor(state)
        if not state.second_window.shown:
            self.close()
            return
        if self._window is None and not self._open(state):
            return
        self._full_screen.follow(self._window, state.second_window.full_screen)
        size = glfw.get_framebuffer_size(self._window)
        if min(size) > 0:
            self._show(*self._content.of(state, size), size)

    def _listen(self, state: AppState) -> None:
        """What a person has done in it since."""
        pressed, self._pressed = self._pressed, []
        for key in pressed:
            if key == glfw.KEY_ESCAPE:
                presenting.leave_second(state)
            elif key == CLOSES[0]:
                presenting.close_second(state)
            else:
                KEYS[key](state)
        if glfw.window_should_close(self._window):
            presenting.close_second(state)
        place = place_of(self._window)
        # Told once it has come to rest, and as it is without the screen.
        if place == self._place and not state.second_window.full_screen:
            presenting.place_second(state, place)
        self._place = place

    def _end_without_monitor(self, state: AppState) -> None:
        """As large as a screen, it would lie over the controls on the one that is left."""
        if self._full_screen.is_lost(self._window):
            presenting.close_second(state)
            actions.announce(state, LOST)

    def _open(self, state: AppState) -> bool:
        place, fills = self._first_place(state)
        glfw.default_window_hints()  # The runner has left its own.
        for hint, value in HINTS.items():
            glfw.window_hint(hint, value)
        window: Any = glfw.create_window(place[2], place[3], "VesselSplat", None, self._first)
        if not window:
            presenting.close_second(state)
            actions.fail(state, "a second window cannot be opened on this screen")
            return False
        self._window, self._drawn, self._place, self._full_screen = window, None, None, FullScreen()
        glfw.set_window_pos(window, *place[:2])
        glfw.set_key_callback(window, self._press)
        glfw.set_window_refresh_callback(window, self._forget)
        presenting.fill_second(state, fills)
        glfw.make_context_current(window)
        glfw.swap_interval(0)  # The first window waits for its screen; both would wait in turn.
        self._view = QuadView(starting.attach())
        glfw.make_context_current(self._first)
        return True

    def _first_place(self, state: AppState) -> tuple[Place, bool]:
        """Where it was, as long as that can be seen; else on another screen, all of it; else beside the first
        window's corner. Whether it fills the screen."""
        kept, first = state.second_window.place, place_of(self._first)
        monitors = glfw.get_monitors()
        if kept is not None and any(shared(kept, monitor) for monitor in monitors):
            return kept, state.second_window.full_screen
        here = nearest(first)
        for monitor in monitors:
            if glfw.get_monitor_pos(monitor) != glfw.get_monitor_pos(here):
                left, top, width, height = glfw.get_monitor_workarea(monitor)
                return (left + (width - SIZE[0]) // 2, top + (height - SIZE[1]) // 2, *SIZE), True
        return (first[0] + GAP, first[1] + GAP, *SIZE), False

    def _press(self, window: object, key: int, scancode: int, action: int, mods: int) -> None:
        plain = mods == 0 and (key in KEYS or key == glfw.KEY_ESCAPE)
        if action != glfw.RELEASE and (plain or (key, mods) == CLOSES):
            self._pressed.append(key)

    def _forget(self, window: object) -> None:
        """The system has lost what was drawn."""
        self._drawn = None

    def _show(self, quads: tuple[Quad, ...], title: str, size: tuple[int, int]) -> None:
        wanted = (size, title, tuple(quad.identity for quad in quads))
        if wanted == self._drawn:
            return
        assert self._view is not None
        self._drawn = wanted
        glfw.set_window_title(self._window, f"{title.capitalize()} · VesselSplat")
        self._content.finish()
        glfw.make_context_current(self._window)
        self._view.draw(quads, size)
        glfw.swap_buffers(self._window)
        glfw.make_context_current(self._first)

    def close(self) -> None:
        """Close the window, if it is open."""
        if self._window is None:
            return
        glfw.make_context_current(self._window)
        if self._view is not None:
            self._view.release()
        glfw.make_context_current(self._first)
        glfw.destroy_window(self._window)
        self._window = self._view = None
