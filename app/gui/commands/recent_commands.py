"""Commands for what was opened lately, which change with the settings."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from pathlib import Path

from app.files.legible import as_label
from app.gui.actions import actions, second_actions
from app.gui.commands.command import Command
from app.gui.state.app_state import AppState
from app.gui.views.recent_names import told_apart


def opening(state: AppState) -> tuple[Command, ...]:
    """To open it again."""
    return tuple(
        Command(label, partial(actions.open_path, path=Path(text)), text=text)
        for label, text in _named(state.settings.recent)
    )


def beside(state: AppState) -> tuple[Command, ...]:
    """To see it beside the first 3D view: runs and splat files alone, and not what is shown already."""
    return tuple(
        Command(label, partial(second_actions.open_second, path=Path(text)), text=text)
        for label, text in _named(map(str, second_actions.offered(state)))
    )


def _named(paths: Iterable[str]) -> list[tuple[str, str]]:
    """What the label says and the path."""
    every = list(paths)
    names = zip(told_apart(every), every, strict=True)
    return [(f"{as_label(name)}##{place}", text) for place, (name, text) in enumerate(names)]
