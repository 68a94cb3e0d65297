"""Keys that mean something else for a while; until it ends they do nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Final

from imgui_bundle import imgui

from app.gui.actions import masking_actions, picture_actions, presenting, tuning_actions
from app.gui.commands.command import Act
from app.gui.state.app_state import AppState

Keys = Mapping[int, Act]
PRESENTATION: Final[Keys] = {
    imgui.Key._1: partial(presenting.show, pane="left"),
    imgui.Key._2: partial(presenting.show, pane="right"),
    imgui.Key._3: partial(presenting.show, pane="3D view"),
    imgui.Key.up_arrow: partial(presenting.step, by=-1),
    imgui.Key.down_arrow: partial(presenting.step, by=1),
    imgui.Key.l: presenting.toggle_labels,
}
TILE: Final[Keys] = {
    imgui.Key.left_arrow: partial(tuning_actions.go, right=-1),
    imgui.Key.right_arrow: partial(tuning_actions.go, right=1),
    imgui.Key.up_arrow: partial(tuning_actions.go, down=-1),
    imgui.Key.down_arrow: partial(tuning_actions.go, down=1),
    imgui.Key._0: lambda state: picture_actions.fit(state.tuning),
}
MASKING: Final[Keys] = {
    imgui.Key.left_bracket: partial(masking_actions.scale_radius, steps=-1),
    imgui.Key.right_bracket: partial(masking_actions.scale_radius, steps=1),
    int(imgui.Key.mod_ctrl) | int(imgui.Key.z): masking_actions.undo,
    int(imgui.Key.mod_ctrl) | int(imgui.Key.y): masking_actions.redo,
}
MASKING_TEXT: Final = (
    ("[ or ]", "a smaller or a larger brush; also Shift and the wheel"),
    ("Ctrl+Z, Ctrl+Y", "undo or redo a stroke on this frame"),
    ("Esc", "stop masking"),
)
TILE_TEXT: Final = (
    ("Arrows", "the neighbouring image"),
    ("0", "fit it"),
    ("Esc", "back to the grid"),
)
PRESENTATION_TEXT: Final = (
    ("1, 2 or 3", "left pane, right pane or 3D view; also Up and Down"),
    ("L", "labels on or off"),
    ("Esc or F5", "end the presentation"),
)


def keys_of(state: AppState) -> Keys:
    """The keys of what is going on, each with what it does; masks can be painted in a presentation, too."""
    presented = PRESENTATION if state.presenting.pane is not None else {}
    if state.masking.active:
        return {**presented, **MASKING}
    if presented:
        return presented
    return TILE if tuning_actions.is_looking(state) else {}
