"""The window bare of panels: the pictures, or splats alone, with menus, timeline and status."""

from __future__ import annotations

from collections.abc import Iterable

from imgui_bundle import hello_imgui, imgui

from app.gui.frame.dockings import SPLATS

ALONE = ("Pictures", SPLATS)


class Bare:
    """Which panels are hidden for it, to be there again afterwards."""

    def __init__(self) -> None:
        self._bare = False
        self._hidden: tuple[str, ...] = ()
        self._in_front: tuple[str, ...] = ()

    def follow(self, wanted: bool, panels: Iterable[hello_imgui.DockableWindow]) -> None:
        """Hide or show, once; a panel that is asked for meanwhile is shown."""
        if wanted == self._bare:
            self._bring_forward(panels)
            return
        self._bare = wanted
        if wanted:
            hidden = [panel for panel in panels if panel.is_visible and panel.label not in ALONE]
            self._hidden = tuple(panel.label for panel in hidden)
            self._in_front = tuple(filter(_is_in_front, self._hidden))
        else:
            hidden = [panel for panel in panels if panel.label in self._hidden]
        for panel in hidden:
            panel.is_visible = not wanted

    def _bring_forward(self, panels: Iterable[hello_imgui.DockableWindow]) -> None:
        """One frame after panels have come back, when the last of several tabs is in front."""
        if self._bare or not self._in_front:
            return
        for panel in panels:
            panel.focus_window_at_next_frame |= panel.label in self._in_front
        self._in_front = ()


def _is_in_front(panel: str) -> bool:
    """Not behind another one's tab."""
    window: imgui.internal.Window | None = imgui.internal.find_window_by_name(panel)
    return window is not None and not window.hidden
