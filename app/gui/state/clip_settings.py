"""What a person has said about a clip, kept for the next time that it is opened."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from pathlib import Path

from pydantic import ConfigDict, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

from app.atomic import write_bytes
from app.picture_mask import PictureMask
from app.provenance import strict_json

MOST_CLIPS = 200
FILE = "clips.json"


@dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="forbid"))
class ClipSettings:
    """Of one clip; a clip of which nothing was said has the defaults."""

    trim: tuple[int, int] | None = None
    """First and last frame that count, from 0."""
    mask: PictureMask = field(default_factory=PictureMask)

    def span(self, count: int) -> tuple[int, int]:
        """First and last frame of a clip of `count` frames."""
        if self.trim is None:
            return 0, count - 1
        first = min(max(self.trim[0], 0), count - 1)
        return first, min(max(self.trim[1], first), count - 1)


CLIPS = TypeAdapter(dict[str, ClipSettings])


def load_clips(folder: Path) -> dict[str, ClipSettings]:
    """By path. A missing or damaged file gives none: nothing in it is precious."""
    try:
        return CLIPS.validate_json((folder / FILE).read_bytes())
    except (OSError, ValidationError):
        return {}


def save_clips(folder: Path, clips: Mapping[str, ClipSettings]) -> None:
    """Atomic; the last MOST_CLIPS of those that differ from the defaults. Raises OSError or UserError."""
    said = [(path, settings) for path, settings in clips.items() if settings != ClipSettings()]
    write_bytes(folder / FILE, strict_json(dict(said[-MOST_CLIPS:]), indent=2).encode())
