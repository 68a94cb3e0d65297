"""One pane alone over the whole window, and one in a second window, as functions on the state."""

from __future__ import annotations

from app.gui.actions import floating_windows
from app.gui.state.app_state import AppState
from app.gui.views.comparison import PANES, PaneName

LABELS_SECONDS = 4.0
"""That labels are there by themselves, at the start and with another pane."""


def panes(state: AppState) -> tuple[PaneName, ...]:
    """Those that have something to show."""
    has_pictures, has_model = state.picture.pictures is not None, state.scene.model is not None
    return tuple(pane for pane in PANES if (has_model if pane == "3D view" else has_pictures))


def draw(state: AppState, *panes: PaneName) -> None:
    """These panes are drawn, so in front."""
    state.presenting.in_sight += panes


def point(state: AppState, pane: PaneName, *, clicked: bool) -> None:
    """The pointer is over this pane, and may have clicked it."""
    state.presenting.under = pane
    if clicked:
        state.presenting.clicked = pane


def begin_frame(state: AppState) -> None:
    """Before panes are drawn, which say that they are, and where the pointer is."""
    state.presenting.under, state.presenting.in_sight = None, ()


# ---- over the whole window


def toggle(state: AppState) -> None:
    """Present the pane under the pointer, or the one that was clicked last, or one that is in front; or end
    the presentation."""
    now = state.presenting
    if now.pane is not None:
        leave(state)
    elif there := panes(state):
        wanted = (now.under, now.clicked, *now.in_sight)
        show(state, next((one for one in wanted if one in there and one in now.in_sight), there[-1]))


def show(state: AppState, pane: PaneName) -> None:
    """Present this one, where it has something to show; its labels for a moment."""
    if pane not in panes(state):
        return
    now, frame = state.presenting, state.window
    if now.pane is None:
        now.was_full_screen, now.labels, frame.full_screen = frame.full_screen, False, True
        floating_windows.close_all(state)  # They would lie over the pane; one that is opened later may.
    now.pane, now.ending, now.labels_until = pane, None, frame.now + LABELS_SECONDS


def step(state: AppState, by: int) -> None:
    """The next pane, or the one before."""
    there = panes(state)
    if state.presenting.pane in there:
        show(state, there[(there.index(state.presenting.pane) + by) % len(there)])


def leave(state: AppState) -> None:
    """All panels again, and the window as large as before."""
    now = state.presenting
    if now.pane is not None:
        now.pane, now.ending, state.window.full_screen = None, now.pane, now.was_full_screen


def end(state: AppState) -> None:
    """The panels are there again."""
    state.presenting.ending = None


def follow(state: AppState) -> None:
    """Once a frame: what is presented may have gone, and ends with the last pane."""
    there = panes(state)
    if state.presenting.pane is not None and state.presenting.pane not in there:
        if there:
            show(state, there[-1])
        else:
            leave(state)


def toggle_labels(state: AppState) -> None:
    """What is presented, or nothing but the image: at once, also in the first moments."""
    now = state.presenting
    now.labels, now.labels_until = not has_labels(state), 0.0


def has_labels(state: AppState) -> bool:
    """Whether what is presented says what it is."""
    return state.presenting.labels or state.window.now < state.presenting.labels_until


# ---- in a window of its own


def toggle_second(state: AppState) -> None:
    """Where it was the last time."""
    second, kept = state.second_window, state.settings
    if not second.shown:
        second.place, second.full_screen = kept.second_place, kept.second_full_screen
    second.shown = not second.shown


def close_second(state: AppState) -> None:
    state.second_window.shown = False


def leave_second(state: AppState) -> None:
    """Its full screen, then the window."""
    if state.second_window.full_screen:
        fill_second(state, False)
    else:
        close_second(state)


def show_in_second(state: AppState, pane: PaneName) -> None:
    """This pane, in the second window, which opens for it."""
    state.second_window.pane = pane
    if not state.second_window.shown:
        toggle_second(state)


def toggle_second_labels(state: AppState) -> None:
    state.second_window.labels = not state.second_window.labels


def fill_second(state: AppState, full_screen: bool) -> None:
    """The second window over the whole screen that it is on, or in its place."""
    state.second_window.full_screen = full_screen


def place_second(state: AppState, place: tuple[int, int, int, int]) -> None:
    """Where a person has put it."""
    state.second_window.place = place
