"""A picture that was saved before, as a summary shows it: its bytes, and what its provenance says of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from pydantic import ValidationError

from app.enhancement.methods import EnhancementSettings
from app.enhancement.records import EnhancedPicture
from app.enhancement.setting_words import worded
from app.errors import UserError
from app.exports.records import EXPORT, MeasuresOf, PaneRecord, PanesPicture, Render
from app.files.embedded import JPEG_START, carried
from app.files.legible import named
from app.files.provenance import facts_of
from app.scenes.records import ViewRecord
from enhance import Statistics
from renderer.file_signatures import PNG_SIGNATURE
from renderer.regular_files import read_whole

KINDS: Final = {PNG_SIGNATURE: "image/png", JPEG_START: "image/jpeg"}
"""By their first bytes, those that browsers show."""
Measured = dict[str, float | None]


@dataclass(frozen=True)
class Part:
    """One line about a picture: something that is in it."""

    shows: str
    settings: str = ""
    measured: Measured | None = None


@dataclass(frozen=True)
class SavedPicture:
    """Its content and what it shows."""

    content: bytes
    media_type: str
    """As browsers call it."""
    title: str
    parts: tuple[Part, ...]


def read_picture(path: Path, measures_of: MeasuresOf = "all images") -> SavedPicture:
    """Raises OSError; UserError: it is no PNG or JPEG, or not one of ours."""
    content = read_whole(path)
    media_type = next((kind for start, kind in KINDS.items() if content.startswith(start)), None)
    if media_type is None:
        raise UserError(f"expected an image that browsers show, PNG or JPEG, got another file: {path}")
    text = carried(content)
    if text is None:
        raise UserError(f"expected an image saved by VesselSplat, found no provenance in it: {path}")
    facts = facts_of(text, path)
    return SavedPicture(content, media_type, _title(facts) or path.stem, tuple(_parts(facts, measures_of)))


def _title(facts: dict[str, Any]) -> str:
    """The clip or the run, and the frame; empty where neither is told."""
    view = (facts.get("views") or [facts])[0]
    sources = facts.get("source"), *(facts.get(kind, view.get(kind)) for kind in ("run", "splats"))
    name = next((str(one["name"]) for one in sources if isinstance(one, dict) and one.get("name")), "")
    # The frame of panes is there also where there are none.
    number = _number(facts if facts.get("panes") else view)
    return f"{name}, frame {number}" if name and number is not None else name


def _number(facts: dict[str, Any]) -> int | None:
    """Of the frame among the clip's, from 1; None: not told."""
    frame, start = facts.get("frame"), facts.get("start", _trim(facts)[0])
    index = frame.get("index") if isinstance(frame, dict) else frame
    return 1 + start + index if isinstance(index, int) and isinstance(start, int) else None


def _trim(facts: dict[str, Any]) -> tuple[object, ...]:
    """Frames of the clip that a view is of, where no start is told: of a window they are not known."""
    if facts.get("window") is not None:
        return (None,)
    clip = facts.get("clip")
    part = clip.get("part") if isinstance(clip, dict) else None
    trim = part.get("trim") if isinstance(part, dict) else None
    return tuple(trim) if isinstance(trim, list) and trim else (0,)


def _parts(facts: dict[str, Any], measures_of: MeasuresOf) -> Iterator[Part]:
    """Of a kind that this version does not know, its name alone."""
    try:
        record = EXPORT.validate_python(facts)
    except ValidationError:
        yield Part(str(facts.get("kind", "image")).capitalize())
        return
    match record:
        case PanesPicture():
            yield from map(_of_pane, record.panes)
            yield from map(_of_scene, record.views)
        case Render():
            yield _of_scene(record)
        case EnhancedPicture():
            settings = _settings(record.params, record.statistics) or named(record.method)
            measures = record.measures if measures_of == "all images" else None
            yield Part("Enhanced", settings, None if measures is None else asdict(measures))
        case _:
            yield Part(record.kind.capitalize())


def _of_pane(pane: PaneRecord) -> Part:
    frames = f"from {pane.view.trained_on}" if pane.view is not None and pane.view.trained_on else ""
    return Part(pane.title.split("   ")[0], _settings(pane.params, pane.statistics) or frames, pane.measured)


def _of_scene(view: ViewRecord) -> Part:
    seen = "3D view" if view.view == "color" else f"3D view, {view.view}"
    return Part(seen, f"from {view.trained_on}" if view.trained_on else "")


def _settings(params: EnhancementSettings | None, used: Statistics | None) -> str:
    return worded(params, used) if params is not None else ""
