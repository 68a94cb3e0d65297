"""What a part of the report says: sentences, tables, diagrams. The same values for page, JSON and app."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Self, TypeGuard

from pydantic import TypeAdapter, ValidationError

from app.errors import UserError
from app.report.diagrams import Diagram, GainDiagram, Growth, Point
from renderer.json_files import read_json

REPORT: Final = "report.json"
"""Its file, beside the page."""
Cell = str | float | int | bool | None
"""A bool is passed (True) or failed; None was not measured."""


@dataclass(frozen=True)
class Column:
    """Of a table."""

    name: str
    form: str = ".4g"
    """How numbers are printed."""
    best: str = ""
    """"high" or "low", where one end is the better one."""


@dataclass(frozen=True, kw_only=True)
class Table:
    """Rows of measurements."""

    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    note: str = ""
    """What the figures are and how they were taken."""


@dataclass(frozen=True, kw_only=True)
class Plate:
    """Work-precision diagrams of the same settings, side by side."""

    title: str
    diagrams: tuple[Diagram, ...]

    @classmethod
    def of_errors(cls, title: str, points: Iterable[Point]) -> Self:
        """One diagram, of the mean errors of images."""
        return cls(title=title, diagrams=(Diagram(measure="mean error, grey levels", points=tuple(points)),))


@dataclass(frozen=True, kw_only=True)
class Section:
    """A part of the report."""

    title: str
    sentences: tuple[str, ...] = ()
    """Each a paragraph."""
    plates: tuple[Plate, ...] = ()
    growths: tuple[Growth, ...] = ()
    gain_diagrams: tuple[GainDiagram, ...] = ()
    tables: tuple[Table, ...] = ()
    not_measured: tuple[str, ...] = ()
    """What the time did not suffice for, or what is missing here, each with the reason."""


def is_number(cell: Cell) -> TypeGuard[int | float]:
    """A finite number, and not a verdict, which is a bool."""
    return isinstance(cell, int | float) and not isinstance(cell, bool) and math.isfinite(cell)


def said(cell: Cell, column: Column) -> str:
    """A verdict in words, a number in the form of its column, a dash where nothing was measured."""
    if isinstance(cell, bool):
        return "pass" if cell else "FAIL"
    if isinstance(cell, str):
        return cell
    if cell is None or math.isnan(cell):
        return "–"
    return f"{cell:d}" if isinstance(cell, int) else format(cell, column.form).replace("%", " %")


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
