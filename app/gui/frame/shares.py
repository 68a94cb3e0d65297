"""Keeps the share that images have of a window while that changes its size.

The runner gives the images all that a window grows by, and takes from them all that it shrinks by. A layout
that it reads has sizes in pixels of a window that may have been larger.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from imgui_bundle import ImVec2, hello_imgui, imgui

from app.gui.frame.dockings import MOST, Node

VIEWS: Final = ("3D view", "Log", "Notes")
"""Panels that grow with the window; others have controls, which need no more room than before."""


class Shares:
    """Of the layout in use, which may change."""

    def __init__(self) -> None:
        self._whole, self._is_new = (0.0, 0.0), False
        self._divided: list[int] = []

    def follow(self, params: hello_imgui.DockingParams) -> None:
        """Before a frame."""
        line = _line(_node(params.dock_space_id_from_name("MainDockSpace")))
        if not line:
            return
        root, before, was_new, divided = line[-1], self._whole, self._is_new, self._divided
        self._divided = _divided(root)
        self._whole = now = root.size.x, root.size.y
        # What was just read is still as large as the window that it is of.
        self._is_new = root.last_frame_alive < 0
        # What was just arranged anew, as other text may have it, is so for the window as it is now.
        changed = was_new or (now != before and divided == self._divided)
        if changed and not self._is_new and min(*before, *now) > 0:
            _fit(root, params.dockable_windows, before, now)


def _fit(
    root: Node,
    panels: Iterable[hello_imgui.DockableWindow],
    before: tuple[float, float],
    now: tuple[float, float],
) -> None:
    """Give what is beside or below the images its part of the pixels `now`, by what it had of those `before`;
    both across and down."""
    divided = _divided(root)
    beside: dict[int, tuple[Node, bool]] = {}
    for panel in panels:
        part = next((node for node in _line(_place_of(panel.label)) if _above(node) in divided), None)
        if part is not None and part.id_ not in divided:
            grows = panel.label in VIEWS or beside.get(_above(part), (part, False))[1]
            beside[_above(part)] = part, grows
    whole, left = ImVec2(*before), ImVec2(*now)
    for above in reversed(divided):
        if above not in beside:
            continue
        node, grows = beside[above]
        axis, size = node.parent_node.split_axis, ImVec2(node.size_ref.x, node.size_ref.y)
        had = size[axis]
        # More than there was: by a layout of a larger window, no hand has moved it there.
        share = had / whole[axis] if had < whole[axis] else MOST
        size[axis] = share * left[axis] if grows else min(had, max(share, MOST) * left[axis])
        imgui.internal.dock_builder_set_node_size(node.id_, size)
        whole[axis], left[axis] = max(whole[axis] - had, 1.0), max(left[axis] - size[axis], 1.0)


def _divided(root: Node) -> list[int]:
    """Around the images, from within."""
    return [node.id_ for node in _line(imgui.internal.dock_builder_get_central_node(root.id_))]


def _place_of(panel: str) -> Node | None:
    """Where the panel is docked, or will be once it is shown."""
    window: imgui.internal.Window | None = imgui.internal.find_window_by_name(panel)
    if window is not None:
        return _node(window.dock_id)
    kept: imgui.internal.WindowSettings | None
    kept = imgui.internal.find_window_settings_by_id(imgui.internal.im_hash_str(panel))
    if kept is not None:
        return _node(kept.dock_id)
    return None


def _node(id_: int | None) -> Node | None:
    node: Node | None = imgui.internal.dock_builder_get_node(id_) if id_ else None
    return node


def _line(node: Node | None) -> list[Node]:
    """The node and all that it is a part of, up to the whole."""
    line = []
    while node is not None:
        line.append(node)
        node = node.parent_node
    return line


def _above(node: Node) -> int:
    """0 for the whole."""
    return next((int(above.id_) for above in _line(node)[1:]), 0)
