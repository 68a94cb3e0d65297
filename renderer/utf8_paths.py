"""Paths that are not UTF-8: video decoders crash on them, and no JSON can name them."""

from __future__ import annotations

from pathlib import Path


def not_utf8(path: Path) -> str | None:
    """The refusal of a path that only the file system can spell; None of any other."""
    try:
        str(path).encode()
    except UnicodeEncodeError:
        return f"expected a path in UTF-8 (rename or move it), got {spelled(str(path))}"
    return None


def spelled(text: str) -> str:
    """The text in UTF-8, bytes of a path that is not in hexadecimal."""
    return text.encode(errors="backslashreplace").decode()
