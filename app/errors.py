"""Mistakes of the user, as opposed to bugs: one clear line, exit code 2, never a traceback."""

from __future__ import annotations


class UserError(Exception):
    """What was expected, what came, and where: shown as it stands."""
