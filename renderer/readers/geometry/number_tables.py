"""Text files of numbers: calibrations and trajectories."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from renderer.camera import FloatArray
from renderer.clip import ClipError
from renderer.regular_files import read_regular


def read_table(path: Path) -> FloatArray:
    """(rows, columns) of the finite numbers in a file; empty lines and what follows a # are left out.

    Raises:
        ClipError: the file is missing or empty, holds other words, or rows of several lengths.
    """
    try:
        lines = read_regular(path).decode(errors="replace").splitlines()
    except OSError as error:
        raise ClipError(f"expected a text file of numbers, got none that can be read: {path}") from error
    rows = [line.partition("#")[0].split() for line in lines]
    try:
        table = np.array([row for row in rows if row], dtype=np.float64)
    except ValueError as error:
        raise ClipError(f"expected rows of as many numbers each, got other words: {path}") from error
    if not table.size or not np.isfinite(table).all():
        got = "infinite ones" if table.size else "none"
        raise ClipError(f"expected finite numbers, got {got}: {path}")
    return table
