"""Paths that are not UTF-8: video decoders crash on them, and run.json cannot name them."""

from __future__ import annotations

from pathlib import Path

from app.errors import UserError


def require_utf8(path: Path) -> None:
    """Raises UserError for a path that only the file system can spell."""
    try:
        str(path).encode()
    except UnicodeEncodeError as error:
        shown = str(path).encode(errors="backslashreplace").decode()
        raise UserError(f"expected a path in UTF-8, rename or move it: {shown}") from error
