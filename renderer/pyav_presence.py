"""Whether PyAV is there and works. It reads videos best; without it, OpenCV does."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from importlib.util import find_spec


def has_pyav() -> bool:
    """Whether it can be used. Loads it."""
    return find_spec("av") is not None and not why_not_pyav()


@cache
def why_not_pyav() -> str:
    """Why the one that is installed cannot be used, in a line; empty where it can, or none is installed."""
    if find_spec("av") is None:
        return ""
    try:
        import_module("av")
    # Libraries that do not fit raise ImportError; a half-removed package whatever it runs into.
    except Exception as error:
        lines = str(error).splitlines() or [type(error).__name__]
        return f"PyAV is installed but cannot be loaded ({lines[0]}), so OpenCV is used for videos"
    return ""
