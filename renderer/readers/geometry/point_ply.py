"""Points of a PLY file, ascii or binary: positions, and colours where there are any."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from renderer.clip import ClipError, SparsePoints
from renderer.ply_elements import PlyError, read_ply
from renderer.regular_files import read_whole

_COLORS = ("red", "green", "blue")


def read_points(path: Path) -> SparsePoints:
    """The vertices of a PLY file: x y z, and red green blue where they are of 8 bits.

    Vertices are expected to be the first element; what follows them is left alone. A point that is
    not finite is dropped.

    Raises:
        ClipError: the file is missing, no PLY, cut off, or has no positions.
    """
    try:
        content = read_whole(path)
    except OSError as error:
        raise ClipError(f"expected a PLY file, got none that can be read: {path}") from error
    try:
        elements = read_ply(content, 1).elements
    except PlyError as error:
        raise ClipError(f"{error}: {path}") from error
    if not elements or elements[0].name != "vertex":
        came = elements[0].name if elements else "none"
        raise ClipError(f"expected vertices as the first element, of plain numbers, got {came}: {path}")
    rows, fields = elements[0].rows, elements[0].fields
    if not set("xyz") <= set(fields):
        raise ClipError(f"expected properties x, y and z, got {' '.join(fields)}: {path}")
    positions = np.stack([rows[name] for name in "xyz"], axis=1).astype(np.float64)
    finite = np.isfinite(positions).all(axis=1)
    shades = [rows[name] for name in _COLORS if name in fields and rows[name].dtype == np.uint8]
    colors = np.stack(shades, axis=1)[finite] if len(shades) == len(_COLORS) else None
    return SparsePoints(positions[finite], colors)
