"""Controls by keyboard: where a walk through them begins, and from panel to panel, menu bar and timeline."""

from __future__ import annotations

from typing import Final

from imgui_bundle import imgui

Window = imgui.internal.Window
MENUS: Final = "##MainMenuBar"
TIMELINE: Final = "##Bottom"
"""As the runner begins its name."""
WITHOUT: Final = ("StatusBar", "Debug##Default")
"""Nothing in them can be pressed."""
FLAGS = imgui.WindowFlags_
NO_STOP: Final = FLAGS.tooltip | FLAGS.popup | FLAGS.no_nav_inputs | FLAGS.no_mouse_inputs


class Walk:
    """Wished for by a key at the end of a frame, and begun in the next before any control is drawn."""

    def __init__(self) -> None:
        self._steps: int | None = None

    def ask(self, steps: int) -> None:
        """So many panels on or back; 0: where the focus is."""
        self._steps = steps

    def follow(self) -> None:
        """Called after each frame has begun: moves the focus by the steps asked for since the last one."""
        steps, self._steps = self._steps, None
        if steps is None or not (there := stops()):
            return
        context = imgui.get_current_context()
        now: Window | None = context.nav_window
        names = [one.name for one in there]
        place = names.index(now.root_window.name) if now and now.root_window.name in names else 0
        window = there[(place + steps) % len(there)]
        imgui.internal.focus_window(window)
        context.nav_layer = (
            imgui.internal.NavLayer.menu if window.name == MENUS else imgui.internal.NavLayer.main
        )
        imgui.internal.nav_init_window(window, False)
        imgui.set_nav_cursor_visible(True)


def stops() -> list[Window]:
    """All windows on screen with something to press, column by column."""
    found = [one for one in imgui.get_current_context().windows if _is_stop(one)]
    return sorted(found, key=lambda one: (one.pos.x, one.pos.y))


def _is_stop(window: Window) -> bool:
    if not window.was_active or window.hidden or window.root_window.name != window.name:
        return False
    if window.flags & NO_STOP or window.name in WITHOUT:
        return False
    return window.name.startswith(TIMELINE) or not window.flags & FLAGS.no_nav_focus
