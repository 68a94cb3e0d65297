"""The elements of a PLY file (Turk, 1994), ascii or binary, of any number of properties in any order."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

TYPES: Final = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8",
}  # fmt: skip
ORDERS: Final = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}
MAGIC: Final = b"ply"
LONGEST_HEADER: Final = 1 << 20
"""Bytes; an end is not looked for beyond."""
_END = re.compile(rb"\nend_header[ \t]*\r?\n")


class PlyError(ValueError):
    """What was expected and what came, without the file."""


@dataclass(frozen=True, eq=False)
class Element:
    """Rows of plain numbers."""

    name: str
    rows: NDArray[Any]
    """(N,) structured: a field for each property."""

    @property
    def fields(self) -> tuple[str, ...]:
        return self.rows.dtype.names or ()


@dataclass(frozen=True, eq=False)
class Ply:
    """What comes before the first element with lists, which is left alone with all that follows it."""

    comments: tuple[str, ...]
    elements: tuple[Element, ...]
    surplus: int
    """Bytes after the last element; 0 where not all of them are read."""


@dataclass(frozen=True)
class _Kind:
    name: str
    count: int
    rows: np.dtype[Any]


def read_ply(content: bytes, most: int | None = None) -> Ply:
    """The elements of plain numbers, or the first `most`, whatever follows them.

    No more memory is taken than the file has bytes for.

    Raises:
        PlyError: no PLY, a header that makes no sense, or fewer rows than it says.
    """
    end = _END.search(content, 0, LONGEST_HEADER)
    if not content.startswith(MAGIC) or end is None:
        within = f" in its first {LONGEST_HEADER} bytes" if len(content) > LONGEST_HEADER else ""
        raise PlyError(f"expected a PLY file, got one without its header{within}")
    lines = [line.split() for line in content[: end.start()].decode("ascii", "replace").split("\n")]
    order = _order(lines)
    kinds = _kinds(lines, order, most)
    body, elements = memoryview(content)[end.end() :], []
    for kind in kinds:
        rows, body = _ascii_rows(body, kind) if order == "=" else _binary_rows(body, kind)
        elements.append(Element(kind.name, rows))
    is_whole = len(kinds) == sum(words[:1] == ["element"] for words in lines)
    left = len(bytes(body).strip() if order == "=" else body)
    comments = tuple(" ".join(words[1:]) for words in lines if words[:1] == ["comment"])
    return Ply(comments, tuple(elements), left if is_whole else 0)


def _order(lines: list[list[str]]) -> str:
    layouts = [words[1] for words in lines if words[:1] == ["format"] and len(words) > 1]
    if len(layouts) != 1 or layouts[0] not in ORDERS:
        raise PlyError(f"expected one format of PLY 1.0, got {' '.join(layouts) or 'none'}")
    return ORDERS[layouts[0]]


def _kinds(lines: list[list[str]], order: str, most: int | None) -> list[_Kind]:
    """Of the elements before the first one with lists."""
    starts = [place for place, words in enumerate(lines) if words[:1] == ["element"]]
    kinds: list[_Kind] = []
    for start, stop in list(pairwise([*starts, len(lines)]))[:most]:
        words = lines[start]
        if len(words) != 3 or not words[2].isdecimal() or len(words[2]) > 15:
            raise PlyError(f"expected an element's name and its number, got: {' '.join(words)}")
        properties = [line for line in lines[start + 1 : stop] if line[:1] == ["property"]]
        if any(line[1:2] == ["list"] for line in properties):
            break
        if any(len(line) != 3 or line[1] not in TYPES for line in properties):
            raise PlyError(f"expected properties of {words[1]} with a type and a name, got another kind")
        fields = {line[2]: order + TYPES[line[1]] for line in properties}
        if not fields or len(fields) != len(properties):
            raise PlyError(f"expected properties of {words[1]} once each, got {' '.join(fields) or 'none'}")
        kinds.append(_Kind(words[1], int(words[2]), np.dtype(list(fields.items()))))
    return kinds


def _binary_rows(body: memoryview, kind: _Kind) -> tuple[NDArray[Any], memoryview]:
    wanted = kind.count * kind.rows.itemsize
    if wanted > len(body):
        raise PlyError(
            f"expected {kind.count} rows of {kind.name} in {wanted} bytes, got {len(body)}: cut off"
        )
    return np.frombuffer(body[:wanted], kind.rows), body[wanted:]


def _ascii_rows(body: memoryview, kind: _Kind) -> tuple[NDArray[Any], memoryview]:
    names = kind.rows.names or ()
    wanted = kind.count * len(names)
    # Each number takes a byte, and all but the last a blank after it.
    words = bytes(body).split(None, wanted) if 2 * wanted <= len(body) + 1 else []
    if len(words) < wanted:
        raise PlyError(f"expected {kind.count} rows of {kind.name}, got fewer: damaged or cut off")
    rest = words[wanted] if len(words) > wanted else b""
    try:
        numbers = np.array(words[:wanted], dtype=np.float64).reshape(kind.count, len(names))
    except ValueError as error:
        raise PlyError(f"expected numbers in {kind.name}, got something else") from error
    rows = np.empty(kind.count, kind.rows)
    for place, name in enumerate(names):
        rows[name] = _cast(numbers[:, place], kind.rows[name])
    return rows, memoryview(rest)


def _cast(numbers: NDArray[np.float64], kind: np.dtype[Any]) -> NDArray[Any]:
    if kind.kind == "f":
        with np.errstate(over="ignore"):
            return numbers.astype(kind)
    limits = np.iinfo(kind)
    if not np.all((numbers >= limits.min) & (numbers <= limits.max)):
        raise PlyError(f"expected whole numbers from {limits.min} to {limits.max}, got others")
    return numbers.astype(kind)
