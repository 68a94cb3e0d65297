"""A report that was written before: its JSON, read back."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from app.errors import UserError
from app.report.section import Section
from renderer.json_files import read_json

SECTIONS = TypeAdapter(dict[str, Section])


@dataclass(frozen=True)
class SavedReport:
    """What `vesselsplat report` measured."""

    clip: str
    utc: str
    machine: dict[str, Any]
    sections: dict[str, Section]


def holds_report(path: Path) -> bool:
    """Whether the file is JSON that looks like a report, damaged or not, and not like cameras."""
    try:
        facts = read_json(path) if path.suffix == ".json" else None
    except (OSError, ValueError):
        return False
    return isinstance(facts, dict) and "parts" in facts


def read_report(path: Path) -> SavedReport:
    """Raises UserError when the file is no report of ours."""
    try:
        facts = read_json(path)
        sections = SECTIONS.validate_python(facts["parts"])
        return SavedReport(facts["clip"]["name"], facts["utc"], facts["machine"], sections)
    except (OSError, ValueError, KeyError, TypeError, ValidationError) as error:
        raise UserError(f"expected the report.json of a report: {path}") from error
