"""The readable part of a JSON object with fields that are damaged or out of range."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final, TypeVar

from pydantic import TypeAdapter, ValidationError

from renderer.json_files import read_json

T = TypeVar("T")
MOST_ITEMS: Final = 200_000
"""Values within one field; each that is wrong takes 10 us to be told. The largest of ours has 100,000."""


def mended(kind: TypeAdapter[T], told: dict[str, Any]) -> tuple[T | None, tuple[str, ...]]:
    """The value with defaults in place of the fields that are not valid, and their names.

    None: it has no valid form, a field that is needed among the damaged ones.
    """
    left_out = [name for name, value in told.items() if _is_larger(value, MOST_ITEMS)]
    told = {name: value for name, value in told.items() if name not in left_out}
    while True:
        try:
            return kind.validate_python(told), tuple(left_out)
        except ValidationError as error:
            places = [each["loc"] for each in error.errors(include_url=False, include_input=False)]
            wrong = sorted({str(place[0]) for place in places if place} & told.keys())
            if not wrong:
                return None, tuple(left_out)
            left_out += wrong
            told = {name: value for name, value in told.items() if name not in wrong}


def mended_file(kind: TypeAdapter[T], path: Path) -> T | None:
    """The same of a file in which nothing is precious; None where nothing can be made of it."""
    try:
        told = read_json(path)
    except (OSError, ValueError):
        return None
    return mended(kind, told)[0] if isinstance(told, dict) else None


def _is_larger(value: Any, limit: int) -> bool:
    """Whether it has more values in its lists and objects."""
    count, inner = 0, [value]
    while inner and count <= limit:
        one = inner.pop()
        if isinstance(one, dict | list):
            count += len(one)
            inner.extend(one.values() if isinstance(one, dict) else one)
    return count > limit
