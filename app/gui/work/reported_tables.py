"""The tables of a report, ready to draw and to sort."""

from __future__ import annotations

from dataclasses import dataclass

from app.report.section import Cell, Section, Table, is_number, said


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
    """Rows by each column, the least first; those that say nothing come last, here and below."""
    falling: tuple[tuple[int, ...], ...]

    def order(self, column: int, *, falls: bool) -> tuple[int, ...]:
        """Rows by a column."""
        return (self.falling if falls else self.rising)[column]


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
        rising=tuple(_order(cells, falls=False) for cells in columns),
        falling=tuple(_order(cells, falls=True) for cells in columns),
    )


def _order(cells: tuple[Cell, ...], *, falls: bool) -> tuple[int, ...]:
    """Rising, numbers come before words."""
    rows = range(len(cells))
    known = [row for row in rows if _speaks(cells[row])]
    known.sort(key=lambda row: (not is_number(cells[row]), _key(cells[row])))
    silent = [row for row in rows if not _speaks(cells[row])]
    return (*(known[::-1] if falls else known), *silent)


def _speaks(cell: Cell) -> bool:
    return isinstance(cell, str | bool) or is_number(cell)


def _key(cell: Cell) -> float | str:
    return float(cell) if is_number(cell) else str(cell)
