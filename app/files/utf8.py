"""Paths that are not UTF-8: video decoders crash on them, and run.json cannot name them."""

from __future__ import annotations

from pathlib import Path

from app.errors import UserError
from renderer.utf8_paths import not_utf8


def require_utf8(path: Path) -> None:
    """Raises UserError for a path that only the file system can spell."""
    if said := not_utf8(path):
        raise UserError(said)
