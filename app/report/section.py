"""What a part of the report says: sentences, tables, diagrams. The same values for page, JSON and app."""

from __future__ import annotations

from dataclasses import dataclass

from app.report.growth_fit import Growth
from app.report.work_precision import Diagram

Cell = str | float | int | bool | None
"""A bool is passed (True) or failed; None was not measured."""


@dataclass(frozen=True, kw_only=True)
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


@dataclass(frozen=True, kw_only=True)
class Section:
    """A part of the report."""

    title: str
    sentences: tuple[str, ...] = ()
    """Each a paragraph."""
    plates: tuple[Plate, ...] = ()
    growths: tuple[Growth, ...] = ()
    tables: tuple[Table, ...] = ()
    not_measured: tuple[str, ...] = ()
    """What the time did not suffice for, or what is missing here, each with the reason."""
