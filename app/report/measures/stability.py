"""Stiff and extreme cases of every equation and kernel: what float32 makes of them, and the bar."""

from __future__ import annotations

from collections.abc import Iterable

from app.report.bench import Bench, Clock
from app.report.measures.enhancement import photo
from app.report.section import Cell, Column, Section, Table
from enhance.stability import Row, stability

COLUMNS = (
    *(Column(name="hazard"), Column(name="case"), Column(name="measured", form=".3g")),
    *(
        Column(name="bar", form=".3g"),
        Column(name="unit"),
        Column(name="verdict"),
        Column(name="what is done"),
    ),
)
SMALLER = 2
"""One pixel in so many along each side: the oracle is slow."""


def measure(bench: Bench, clock: Clock) -> Section:
    """Of both libraries."""
    bench.say("stability of the enhancement")
    tables = {"Enhancement": _cells(stability(photo(bench)[::SMALLER, ::SMALLER].copy()))}
    failed = sum(row[5] is False for rows in tables.values() for row in rows)
    count = sum(len(rows) for rows in tables.values())
    return Section(
        title="Stability: stiff and extreme cases",
        sentences=(
            f"{count} cases, {failed} failed. Each is float32, as the product computes, against float64 or "
            "against what must hold exactly; each is a test as well.",
        ),
        tables=tuple(Table(title=name, columns=COLUMNS, rows=rows) for name, rows in tables.items()),
    )


def _cells(rows: Iterable[Row]) -> tuple[tuple[Cell, ...], ...]:
    return tuple((row.hazard, row.case, row.measured, row.bar, row.unit, row.passed, "") for row in rows)
