"""Writing what the app remembers, as one of several windows: each brings what has changed in it, and what the
others have written meanwhile stays."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, TypeVar

from app.files.atomic import write_bytes
from app.files.mended import mended_file
from app.gui.work.settings import (
    FILE,
    RECENT_LIMIT,
    SETTINGS,
    SETTINGS_FILE,
    KnownClip,
    Settings,
    clips_content,
    load_clips,
    load_settings,
    settings_content,
)

Kept = TypeVar("Kept", Settings, KnownClip)


@dataclass(frozen=True, eq=False)
class KeepSettings:
    """The settings of this window, and `before`: those of its request before this one, or as it read them."""

    file: Path
    settings: Settings
    before: Settings


class SettingsKeeper:
    """Writes the settings of one window; what a write that failed was to bring, the next one brings."""

    def __init__(self) -> None:
        self._owed: Settings | None = None
        """Those before the first write that has failed since the last one that went well."""

    def keep(self, request: KeepSettings) -> Iterator[Settings]:
        """What the file holds now. Raises OSError or UserError."""
        self._owed = before = self._owed or request.before
        # Of a file that is gone or damaged others have nothing to keep.
        found = mended_file(SETTINGS, request.file) or before
        settings = merged(request.settings, before, found)
        write_bytes(request.file, settings_content(settings))
        self._owed = None
        yield settings


def merged(mine: Settings, before: Settings, found: Settings) -> Settings:
    """What was found in the file, with what has changed from `before` to `mine`.

    Where paths are not remembered after that, there are none.
    """
    changed = _changed(mine, before)
    newest = (item for item in (*mine.recent, *found.recent) if item not in before.recent)
    left = (item for item in mine.recent if item in found.recent)
    changed["recent"] = tuple(dict.fromkeys((*newest, *left)))[:RECENT_LIMIT]
    visited = {name: folder for name, folder in mine.folders.items() if before.folders.get(name) != folder}
    changed["folders"] = found.folders | visited
    settings = replace(found, **changed)
    return settings if settings.remember_recent else settings.remembering(False)


@dataclass(frozen=True, eq=False)
class KeepClip:
    """What is known of one clip in this window, and `before`: what was before its last choice."""

    folder: Path
    path: str
    known: KnownClip
    before: KnownClip


def keep_clip(request: KeepClip) -> Iterator[None]:
    """Answers with nothing. Raises OSError or UserError.

    Where another window has switched off that paths are remembered, nothing is written.
    """
    if not load_settings(request.folder / SETTINGS_FILE).remember_recent:
        yield None
        return
    clips = load_clips(request.folder)
    # At the end: those of which nothing is chosen for long are forgotten.
    there = clips.pop(request.path, request.known)
    chosen = _changed(request.known, request.before)
    write_bytes(request.folder / FILE, clips_content({**clips, request.path: replace(there, **chosen)}))
    yield None


def _changed(mine: Kept, before: Kept) -> dict[str, Any]:
    """The fields that are others than before."""
    said = {each.name: getattr(mine, each.name) for each in fields(mine)}
    return {name: value for name, value in said.items() if value != getattr(before, name)}
