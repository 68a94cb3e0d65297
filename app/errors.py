"""Mistakes of the user, as opposed to bugs: one clear line, exit code 2, never a traceback."""

from __future__ import annotations

from pathlib import Path


class UserError(Exception):
    """What was expected, what came, and where: shown as it stands."""


def sentence(error: Exception) -> str:
    """What went wrong as a person reads it: of the system, without its number and the folder."""
    if isinstance(error, OSError) and error.strerror:
        name = f": {Path(str(error.filename)).name}" if error.filename else ""
        return f"{error.strerror}{name}"
    return str(error) or type(error).__name__
