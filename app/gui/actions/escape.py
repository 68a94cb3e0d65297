"""What Escape leaves: the innermost thing that is open, and nothing else. Functions on the state."""

from __future__ import annotations

from collections.abc import Callable

from app.gui.actions import (
    actions,
    camera_actions,
    clip_actions,
    edit_actions,
    floating_windows,
    guide_actions,
    masking_actions,
    presenting,
    tuning_actions,
    window_actions,
)
from app.gui.actions.floating_windows import Floating
from app.gui.state.app_state import AppState

Open = tuple[Callable[[AppState], bool], Callable[[AppState], None]]
"""Whether one kind of thing is open, and how it is left."""


def _window(part: Callable[[AppState], Floating]) -> Open:
    return lambda s: part(s).shown, lambda s: floating_windows.show(part(s), False)


FLOATING: dict[str, Open] = {
    "About VesselSplat": _window(lambda s: s.about),
    guide_actions.TITLE: _window(lambda s: s.guide),
    "Keys and mouse": (lambda s: s.window.help_open, lambda s: actions.show_help(s, False)),
    "Open live source": _window(lambda s: s.live.choice),
    "Export": _window(lambda s: s.exports),
    "Case summary": _window(lambda s: s.summary),
    "Enhance files and folders": _window(lambda s: s.batches),
}
"""Windows that lie over each other, by their titles."""
INNERMOST_FIRST: tuple[Open, ...] = (
    (lambda s: bool(s.picture.mask_tool), clip_actions.stop_mask),
    (lambda s: bool(s.masking.line), masking_actions.drop_stroke),
    (lambda s: s.masking.active, masking_actions.toggle),
    (lambda s: bool(s.editing.stroke), edit_actions.drop_stroke),
    (lambda s: s.scene.viewer.measuring, camera_actions.toggle_measuring),
    (lambda s: s.scene.viewer.flying, camera_actions.toggle_flight),
    (lambda s: s.editing.active, edit_actions.toggle),
    (tuning_actions.is_looking, lambda s: tuning_actions.look_at(s, None)),
    (lambda s: s.presenting.pane is not None, presenting.leave),
    (lambda s: s.window.bare, window_actions.toggle_panels),
    (lambda s: s.window.full_screen, window_actions.toggle_full_screen),
    # Last: who leaves a tool has not read the error that has come meanwhile.
    (lambda s: s.window.banner is not None, actions.dismiss),
)


def leave_innermost(state: AppState, nearness: Callable[[str], int] = lambda title: 0) -> bool:
    """Dialogs before tools, a drag before the tool that it is made with; menus and questions have closed by
    then. False where there is nothing to leave.

    `nearness` is of a window of that title, the largest in front.
    """
    windows = [FLOATING[title] for title in sorted(FLOATING, key=nearness, reverse=True)]
    for is_open, leave in (*windows, *INNERMOST_FIRST):
        if is_open(state):
            leave(state)
            return True
    return False
