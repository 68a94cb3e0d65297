"""The window bare of panels: the pictures, or splats alone, with menus, timeline and status."""

from __future__ import annotations

from collections.abc import Iterable

from imgui_bundle import hello_imgui

from app.gui.frame.dockings import SPLATS

ALONE = ("Pictures", SPLATS)


class Bare:
    """Which panels are hidden for it, to be there again afterwards."""

    def __init__(self) -> None:
        self._bare = False
        self._hidden: tuple[str, ...] = ()

    def follow(self, wanted: bool, panels: Iterable[hello_imgui.DockableWindow]) -> None:
        """Hide or show, once; a panel that is asked for meanwhile is shown."""
        if wanted == self._bare:
            return
        self._bare = wanted
        if wanted:
            hidden = [panel for panel in panels if panel.is_visible and panel.label not in ALONE]
            self._hidden = tuple(panel.label for panel in hidden)
        else:
            hidden = [panel for panel in panels if panel.label in self._hidden]
        for panel in hidden:
            panel.is_visible = not wanted
