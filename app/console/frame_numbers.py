"""The numbers of frames as `--frames` takes them, of every command alike."""

from __future__ import annotations

import re
from collections.abc import Sequence

from app.errors import UserError

SAID = "numbers and ranges with both ends, such as 7 10:59 or 7,10:59"


def frame_numbers(texts: Sequence[str], count: int | None = None) -> list[int]:
    """In the order given, from 0, each once; a range A:B holds both ends, and commas separate as spaces do.

    Raises:
        UserError: anything else, a range that ends before it begins, or of a clip of `count` frames one that
            it has not.
    """
    most = 2**31 if count is None else count
    numbers: list[int] = []
    for text in (part for word in texts for part in word.split(",")):
        found = re.fullmatch(r"(\d{1,9})(?::(\d{1,9}))?", text, re.ASCII)
        first, last = (int(found[1]), int(found[2] or found[1])) if found else (0, most)
        if not first <= last < most:
            within = "" if count is None else f", from 0 to {count - 1}"
            raise UserError(f"--frames: expected {SAID}{within}, got {text!r}")
        numbers.extend(range(first, last + 1))
    return list(dict.fromkeys(numbers))
