"""The commands of the presentation and of the second window."""

from __future__ import annotations

from functools import partial

from app.gui.actions import presenting
from app.gui.commands.command import Command, Section
from app.gui.state.app_state import AppState
from app.gui.views.comparison import PaneName

PANE_LABELS: dict[PaneName, str] = {"left": "Left pane", "right": "Right pane", "3D view": "3D view"}


def presenting_commands() -> tuple[Command, ...]:
    return (
        Command("Presentation", presenting.toggle, ("F5",),
                text="one pane alone on the whole screen: the one under the pointer, or clicked last",
                applies=lambda s: bool(presenting.panes(s)), ticked=lambda s: s.presenting.pane is not None,
                synonyms=("slideshow", "teaching", "lecture", "slides")),
        Command("Second window", presenting.toggle_second, ("Shift+F5",),
                text="one pane in a window of its own, for a second monitor; the controls stay here",
                ticked=lambda s: s.second_window.shown,
                synonyms=("monitor", "screen", "projector", "external")),
    )  # fmt: skip


def second_section() -> Section:
    """What the second window shows."""
    labels = (
        Command("Second window: labels", presenting.toggle_second_labels, applies=_is_open,
                ticked=lambda s: s.second_window.labels),
        Command("Second window: full screen", _fill, applies=_is_open,
                ticked=lambda s: s.second_window.full_screen),
    )  # fmt: skip
    return Section("View", (*map(_in_second, PANE_LABELS), *labels), "Second window shows")


def _in_second(pane: PaneName) -> Command:
    show = partial(presenting.show_in_second, pane=pane)
    return Command(f"Second window: {PANE_LABELS[pane]}", show,
                   ticked=lambda s: s.second_window.shown and s.second_window.pane == pane)  # fmt: skip


def _is_open(state: AppState) -> bool:
    return state.second_window.shown


def _fill(state: AppState) -> None:
    presenting.fill_second(state, not state.second_window.full_screen)
