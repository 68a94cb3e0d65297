"""Writing what the app remembers, as one of several windows: each brings what has changed in it, and what the
others have written meanwhile stays."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from pathlib import Path

from app.files.atomic import write_bytes
from app.files.mended import mended_file
from app.gui.work.settings import (
    FILE,
    RECENT_LIMIT,
    SETTINGS,
    KnownClip,
    Settings,
    clips_content,
    load_clips,
    settings_content,
)


@dataclass(frozen=True, eq=False)
class KeepSettings:
    """The settings of this window, and `before`: those that it last read from the file or wrote to it."""

    file: Path
    settings: Settings
    before: Settings


def keep_settings(request: KeepSettings) -> Iterator[Settings]:
    """What the file holds now. Raises OSError or UserError."""
    # Of a file that is gone or damaged others have nothing to keep.
    found = mended_file(SETTINGS, request.file) or request.before
    settings = merged(request.settings, request.before, found)
    write_bytes(request.file, settings_content(settings))
    yield settings


def merged(mine: Settings, before: Settings, found: Settings) -> Settings:
    """What was found in the file, with what has changed from `before` to `mine`.

    Where paths are not remembered after that, there are none.
    """
    said = {each.name: getattr(mine, each.name) for each in fields(mine)}
    changed = {name: value for name, value in said.items() if value != getattr(before, name)}
    newest = (item for item in (*mine.recent, *found.recent) if item not in before.recent)
    left = (item for item in mine.recent if item in found.recent)
    changed["recent"] = tuple(dict.fromkeys((*newest, *left)))[:RECENT_LIMIT]
    visited = {name: folder for name, folder in mine.folders.items() if before.folders.get(name) != folder}
    changed["folders"] = found.folders | visited
    settings = replace(found, **changed)
    return settings if settings.remember_recent else settings.remembering(False)


@dataclass(frozen=True, eq=False)
class KeepClip:
    """What was chosen for one clip, beside what the folder's file says of others."""

    folder: Path
    path: str
    known: KnownClip


def keep_clip(request: KeepClip) -> Iterator[None]:
    """Answers with nothing. Raises OSError or UserError."""
    others = {path: known for path, known in load_clips(request.folder).items() if path != request.path}
    write_bytes(request.folder / FILE, clips_content({**others, request.path: request.known}))
    yield None
