"""JSON from files that anyone may have made: their size and depth are held within bounds."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from renderer.regular_files import read_regular

DEEPEST = 100
"""Lists and objects within one another. Our own files have fewer than 12."""


def parsed(content: str | bytes) -> Any:
    """The value of a JSON text in UTF-8.

    Raises:
        ValueError: it is none, is nested too deeply, or holds NaN or an infinity, which JSON has no word for,
            or a number with a fraction or an exponent that is too large for a float.
    """
    try:
        value = json.loads(content, parse_constant=_refuse, parse_float=_finite)
    except UnicodeDecodeError:
        raise ValueError("expected text in UTF-8, got other bytes") from None
    except RecursionError:
        raise ValueError(TOO_DEEP) from None
    if _is_deeper(value, DEEPEST):
        raise ValueError(TOO_DEEP)
    return value


def read_json(path: Path) -> Any:
    """What `parsed` gives of a file.

    Raises:
        OSError: it cannot be read, is no regular file, or is too large.
        ValueError: see `parsed`.
    """
    return parsed(read_regular(path))


TOO_DEEP = f"expected at most {DEEPEST} lists and objects within one another, got more"


def _finite(number: str) -> float:
    """Numbers beyond what floats hold would be infinite."""
    value = float(number)
    if not math.isfinite(value):
        _refuse(number)
    return value


def _refuse(constant: str) -> None:
    raise ValueError(f"expected numbers, got {constant}")


def _is_deeper(value: Any, limit: int) -> bool:
    level = [value]
    for _ in range(limit):
        inner = [each for each in level if isinstance(each, dict | list)]
        if not inner:
            return False
        level = [one for each in inner for one in (each.values() if isinstance(each, dict) else each)]
    return any(isinstance(each, dict | list) for each in level)
