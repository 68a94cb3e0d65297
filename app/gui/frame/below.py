"""What is below the pictures keeps its share of the height when the window changes its own.

The runner would give all that a window grows by to the pictures.
"""

from __future__ import annotations

from typing import Final

from imgui_bundle import ImVec2, hello_imgui, imgui

STEP: Final = 3.0
"""Pixels by which rounding may be off; a hand that moves the line between both moves it further."""


class Below:
    """Of the layout in use, which may change."""

    def __init__(self) -> None:
        self._of, self._whole, self._share = 0, 0.0, 0.0

    def follow(self) -> None:
        """Before a frame."""
        id_ = hello_imgui.get_runner_params().docking_params.dock_space_id_from_name("Below")
        node = imgui.internal.dock_builder_get_node(id_) if id_ else None
        above = None if node is None else node.parent_node
        if node is None or above is None or above.size.y < 1:
            return
        if node.id_ == self._of and above.size.y != self._whole:
            height = self._share * above.size.y
            imgui.internal.dock_builder_set_node_size(node.id_, ImVec2(node.size_ref.x, height))
        elif node.id_ != self._of or abs(node.size_ref.y - self._share * above.size.y) > STEP:
            self._share = node.size_ref.y / above.size.y
        self._of, self._whole = node.id_, above.size.y
