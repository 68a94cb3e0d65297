"""Tables as CSV, which people open in spreadsheets."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

FORMULA: Final = ("=", "+", "-", "@", "\t", "\r")
"""A text that begins so is run by spreadsheets. Source: OWASP, CSV Injection."""


def csv_table(columns: Sequence[str], rows: Iterable[Mapping[str, object]]) -> bytes:
    """UTF-8, with a question mark for what is none in a file's name; an empty field is what a row lacks, None
    and NaN. A text that would be run as a formula, such as the name of a file, begins with an apostrophe;
    numbers are as they are."""
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(columns)
    writer.writerows([_field(row.get(name)) for name in columns] for row in rows)
    return text.getvalue().encode(errors="replace")


def _field(value: object) -> object:
    if value is None or value != value:
        return ""
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULA) else value
