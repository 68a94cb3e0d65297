"""What the cells of a table say, on the page and in the window."""

from __future__ import annotations

import math
from typing import TypeGuard

from app.report.section import Cell, Column


def is_number(cell: Cell) -> TypeGuard[int | float]:
    """Finite, and no verdict."""
    return isinstance(cell, int | float) and not isinstance(cell, bool) and math.isfinite(cell)


def said(cell: Cell, column: Column) -> str:
    """A verdict in words, a number in the form of its column, a dash where nothing was measured."""
    if isinstance(cell, bool):
        return "pass" if cell else "FAIL"
    if isinstance(cell, str):
        return cell
    if cell is None or math.isnan(cell):
        return "–"
    return f"{cell:d}" if isinstance(cell, int) else format(cell, column.form)
