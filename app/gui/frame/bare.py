"""Hides some or all panels of the window, and brings them back."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from imgui_bundle import hello_imgui, imgui

from app.gui.frame.dockings import SPLATS

ALONE = ("Images", SPLATS)


class Bare:
    """Which panels are hidden for it, to be there again afterwards."""

    def __init__(self) -> None:
        self._kept: Collection[str] | None = None
        self._hidden: frozenset[str] = frozenset()
        self._in_front: frozenset[str] = frozenset()
        self._returned: frozenset[str] = frozenset()

    def follow(self, kept: Collection[str] | None, panels: Iterable[hello_imgui.DockableWindow]) -> None:
        """Hide all but those that are `kept`, or show all (None) again, once; a panel that is asked for
        meanwhile is shown."""
        if kept == self._kept:
            self._bring_forward(panels)
            return
        self._kept = kept
        gone = [panel for panel in panels if panel.is_visible and not self._stays(panel)]
        back = [panel for panel in panels if panel.label in self._hidden and self._stays(panel)]
        self._hidden = self._hidden.union(panel.label for panel in gone)
        self._hidden = self._hidden.difference(panel.label for panel in back)
        self._in_front = self._in_front.union(panel.label for panel in gone if _is_in_front(panel.label))
        self._returned = self._in_front.intersection(panel.label for panel in back)
        self._in_front -= self._returned
        for panel in (*gone, *back):
            panel.is_visible = panel in back

    @property
    def is_over(self) -> bool:
        """All panels are there, in front those that were."""
        return self._kept is None and self.has_returned

    @property
    def has_returned(self) -> bool:
        """Of the panels that came back, those are in front that were."""
        return not self._returned

    def _stays(self, panel: hello_imgui.DockableWindow) -> bool:
        return self._kept is None or panel.label in self._kept

    def _bring_forward(self, panels: Iterable[hello_imgui.DockableWindow]) -> None:
        """One frame after panels have come back, when the last of several tabs is in front."""
        if not self._returned:
            return
        for panel in panels:
            panel.focus_window_at_next_frame |= panel.label in self._returned
        self._returned = frozenset()


def _is_in_front(panel: str) -> bool:
    """Whether a panel is on screen, not behind the tab of another one."""
    window: imgui.internal.Window | None = imgui.internal.find_window_by_name(panel)
    return window is not None and not window.hidden
