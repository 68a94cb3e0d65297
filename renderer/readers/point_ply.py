"""Points of a PLY file (Turk, 1994), ascii or binary: positions, and colours where there are any."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from renderer.clip import ClipError, SparsePoints

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8",
}  # fmt: skip
_ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}
_END = re.compile(rb"\nend_header\r?\n")
_COLORS = ("red", "green", "blue")


def read_points(path: Path) -> SparsePoints:
    """The vertices of a PLY file: x y z, and red green blue where they are of 8 bits.

    Vertices are expected to be the first element; what follows them is left alone. A point that is
    not finite is dropped.

    Raises:
        ClipError: the file is missing, no PLY, cut off, or has no positions.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise ClipError(f"expected a PLY file, got none that can be read: {path}") from error
    header = _header(content, path)
    try:
        columns = _columns(content[header.size :], header)
    except ValueError as error:
        raise ClipError(f"expected {header.count} points, got a damaged or cut off file: {path}") from error
    positions = np.stack([columns[name] for name in "xyz"], axis=1).astype(np.float64)
    finite = np.isfinite(positions).all(axis=1)
    shades = [columns[name] for name in _COLORS if columns.get(name, positions).dtype == np.uint8]
    colors = np.stack(shades, axis=1)[finite] if len(shades) == len(_COLORS) else None
    return SparsePoints(positions[finite], colors)


@dataclass(frozen=True)
class _Header:
    ascii: bool
    count: int
    kind: np.dtype[Any]
    """One vertex, with a field for each property."""
    size: int
    """Bytes of the header."""


def _header(content: bytes, path: Path) -> _Header:
    end = _END.search(content)
    if not content.startswith(b"ply") or end is None:
        raise ClipError(f"expected a PLY file, got one without its header: {path}")
    lines = [line.split() for line in content[: end.start()].decode("ascii", "replace").splitlines()]
    layouts = [words[1] for words in lines if words[:1] == ["format"] and len(words) > 1]
    starts = [place for place, words in enumerate(lines) if words[:1] == ["element"]]
    if len(layouts) != 1 or layouts[0] not in _ORDERS or not starts:
        raise ClipError(f"expected PLY 1.0 with elements, got {' '.join(layouts) or 'no format'}: {path}")
    element = lines[starts[0]]
    if len(element) != 3 or element[1] != "vertex" or not element[2].isdecimal():
        raise ClipError(f"expected vertices as the first element, got {' '.join(element)}: {path}")
    of_vertex = lines[starts[0] + 1 : (starts[1:] or [len(lines)])[0]]
    properties = [words for words in of_vertex if words[:1] == ["property"]]
    if any(len(words) != 3 or words[1] not in _TYPES for words in properties):
        raise ClipError(f"expected vertices of plain numbers, got a property of another kind: {path}")
    order = _ORDERS[layouts[0]]
    fields = {words[2]: order + _TYPES[words[1]] for words in properties}
    if not set("xyz") <= fields.keys() or len(fields) != len(properties):
        raise ClipError(f"expected properties x, y and z once, got {' '.join(fields) or 'none'}: {path}")
    return _Header(layouts[0] == "ascii", int(element[2]), np.dtype(list(fields.items())), end.end())


def _columns(body: bytes, header: _Header) -> dict[str, NDArray[Any]]:
    """The values of each property by its name. Raises ValueError when there are too few, or no numbers."""
    names = header.kind.names or ()
    if not header.ascii:
        rows = np.frombuffer(body, header.kind, header.count)
        return {name: rows[name] for name in names}
    wanted = header.count * len(names)
    numbers = np.array(body.split(None, wanted)[:wanted], dtype=np.float64).reshape(header.count, len(names))
    return {name: numbers[:, place].astype(header.kind[name]) for place, name in enumerate(names)}
