"""Choosing a folder or a file: the desktop's own dialog, or where there is none the one in the window."""

from __future__ import annotations

import os
import shutil
import sys
from dataclasses import replace
from pathlib import Path

from imgui_bundle import portable_file_dialogs as desktop

from app.files.legible import legible
from app.gui.actions import actions, browse_actions
from app.gui.state.app_state import AppState
from app.gui.state.choosing import Choosing
from app.gui.work.listing import nearest

OpenDialog = desktop.select_folder | desktop.open_file | desktop.save_file


def has_desktop_dialogs() -> bool:
    """On Linux they are programs of their own that may be missing, which looks like a cancelled dialog."""
    return not sys.platform.startswith("linux") or any(map(shutil.which, ("zenity", "kdialog")))


class Dialogs:
    """At most one dialog at a time."""

    def __init__(self) -> None:
        self._desktop: OpenDialog | None = None
        self._choosing: Choosing | None = None

    def follow(self, state: AppState) -> None:
        """Once a frame: ask what is to be asked, and take the answer of the desktop's dialog."""
        choosing = actions.taken_choice(state)
        if choosing is not None and self._desktop is None:
            if has_desktop_dialogs():
                self._desktop, self._choosing = _asked(choosing), choosing
            else:
                browse_actions.begin(state, choosing)
        if self._desktop is None or self._choosing is None or not self._desktop.ready(0):
            return
        result = self._desktop.result()
        (path, *_), choosing = (*([result] if isinstance(result, str) else result), ""), self._choosing
        self._desktop = self._choosing = None
        if path:
            _take(state, choosing, Path(path))


def _asked(choosing: Choosing) -> OpenDialog:
    """macOS answers a folder that is not there as a cancelled dialog, and takes no folder with a name."""
    is_mac = sys.platform == "darwin"
    folder = (nearest(choosing.start) if is_mac else None) or choosing.start
    title, start = choosing.question.title, legible(str(folder))
    if choosing.kind == "folder":
        return desktop.select_folder(title, start)
    filters = [
        text
        for one in choosing.question.filters
        for text in (one.label, " ".join(f"*{suffix}" for suffix in one.suffixes) or "*")
    ]
    if choosing.kind == "save":
        proposed = choosing.name if is_mac else str(folder / choosing.name)
        return desktop.save_file(title, legible(proposed), filters)
    return desktop.open_file(title, start, filters)


def _take(state: AppState, choosing: Choosing, answer: Path) -> None:
    """The desktop's dialog has asked about the name without its suffix: before another file is replaced, the
    one in the window asks."""
    path = _named(answer, choosing)
    if path != answer and os.path.lexists(path):
        browse_actions.begin(state, replace(choosing, start=path.parent, name=path.name))
    else:
        browse_actions.chosen(state, choosing, path)


def _named(path: Path, choosing: Choosing) -> Path:
    """With the suffix that a file to be written needs, which some dialogs leave out."""
    if choosing.kind != "save":
        return path
    (suffix, *_) = choosing.question.filters[0].suffixes
    return path if path.suffix.lower() == suffix else path.with_name(f"{path.name}{suffix}")
