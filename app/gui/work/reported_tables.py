"""The tables of a report, ready to draw and to sort."""

from __future__ import annotations

from dataclasses import dataclass

from app.report.cells import is_number, said
from app.report.section import Cell, Section, Table


@dataclass(frozen=True, eq=False)
class ShownTable:
    """Text, and the order of the rows by each column."""

    title: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numbers: tuple[bool, ...]
    """Columns that hold numbers, which stand at the right."""
    failed: frozenset[tuple[int, int]]
    """Row and column of verdicts that are bad."""
    note: str
    rising: tuple[tuple[int, ...], ...]
    """Of each column: rows that say something, the least first."""

    def order(self, column: int, *, falls: bool) -> tuple[int, ...]:
        """Rows by a column; those that say nothing come last both ways."""
        known = self.rising[column]
        silent = tuple(row for row in range(len(self.rows)) if row not in set(known))
        return (*(known[::-1] if falls else known), *silent)


@dataclass(frozen=True, eq=False)
class ReportPart:
    """A section of a report."""

    title: str
    sentences: tuple[str, ...]
    tables: tuple[ShownTable, ...]
    not_measured: tuple[str, ...]


def part_of(section: Section) -> ReportPart:
    """All of it but the diagrams."""
    return ReportPart(
        section.title, section.sentences, tuple(map(shown, section.tables)), section.not_measured
    )


def shown(table: Table) -> ShownTable:
    """The same text as on the page."""
    columns = list(zip(*table.rows, strict=True)) or [() for _ in table.columns]
    return ShownTable(
        title=table.title,
        heads=tuple(column.name for column in table.columns),
        rows=tuple(
            tuple(said(cell, column) for cell, column in zip(row, table.columns, strict=True))
            for row in table.rows
        ),
        numbers=tuple(any(map(is_number, cells)) for cells in columns),
        failed=frozenset(
            (row, place)
            for row, cells in enumerate(table.rows)
            for place, cell in enumerate(cells)
            if cell is False
        ),
        note=table.note,
        rising=tuple(map(_rising, columns)),
    )


def _rising(cells: tuple[Cell, ...]) -> tuple[int, ...]:
    """Numbers before words."""
    known = [(not is_number(cell), row) for row, cell in enumerate(cells) if _speaks(cell)]
    return tuple(row for _, row in sorted(known, key=lambda each: (each[0], _key(cells[each[1]]))))


def _speaks(cell: Cell) -> bool:
    return isinstance(cell, str | bool) or is_number(cell)


def _key(cell: Cell) -> float | str:
    return float(cell) if is_number(cell) else str(cell)
