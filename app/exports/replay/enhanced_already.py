"""Whether a file that is opened was enhanced before: a second time is hardly what is meant."""

from __future__ import annotations

from pathlib import Path

from app.errors import UserError
from app.exports.replay.recorded import Facts, recorded

ENHANCED = ("enhanced picture", "enhanced video")


def enhanced_already(path: Path) -> str:
    """A line of warning, by the record in the file or beside it; empty where that says nothing of it."""
    if not path.is_file():
        return ""
    try:
        facts = recorded(path)
    except (UserError, OSError):
        return ""
    method = _method(facts)
    if method is None:
        return ""
    return f"{path.name} is enhanced already by VesselSplat{method}: it is no original"


def _method(facts: Facts) -> str | None:
    """The end of the sentence about it; None: nothing of it is enhanced. Whoever wrote the record, it may be
    of any form."""
    panes = facts.get("panes")
    if isinstance(panes, list):
        shown = [pane.get("shows") for pane in panes if isinstance(pane, dict)]
        return "" if "setting" in shown or "method" in shown else None
    if facts.get("kind") not in ENHANCED:
        return None
    pictures = facts.get("pictures")
    first = pictures[0] if isinstance(pictures, list) and pictures else facts
    method = first.get("method") if isinstance(first, dict) else None
    return f", method {method}" if isinstance(method, str) else ""
