"""What a person has said about a clip, kept for the next time that it is opened."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from pydantic import TypeAdapter

from app.files.mended import mended
from app.files.provenance import strict_json
from app.runs.clip_selection import WHOLE, ClipPart
from renderer.json_files import read_json

MOST_CLIPS = 200
FILE = "clips.json"
CLIPS = TypeAdapter(dict[str, ClipPart])


def load_clips(folder: Path) -> dict[str, ClipPart]:
    """By path, those that can be read: nothing in it is precious."""
    try:
        told = read_json(folder / FILE)
    except (OSError, ValueError):
        return {}
    if not isinstance(told, dict):
        return {}
    return mended(CLIPS, dict(list(told.items())[-MOST_CLIPS:]))[0] or {}


def clips_content(clips: Mapping[str, ClipPart]) -> bytes:
    """The whole file: the last MOST_CLIPS of those that differ from the defaults."""
    said = [(path, part) for path, part in clips.items() if part != WHOLE]
    return strict_json(dict(said[-MOST_CLIPS:]), indent=2).encode()
