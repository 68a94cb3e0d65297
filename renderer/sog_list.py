"""The list of an unpacked SOG, a folder of splats: how it is known from other JSON."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from renderer.json_files import parsed
from renderer.regular_files import read_regular

LIST: Final = "meta.json"
"""Ends the names of lists; that of one level of detail is called so."""


def is_unpacked_sog(folder: Path) -> bool:
    return is_sog_list(folder / LIST)


def is_sog_list(path: Path) -> bool:
    """Whether a file is the list of an unpacked SOG, by its name and what it says."""
    try:
        return path.name.endswith(LIST) and is_list(read_regular(path), path.name)
    except OSError:
        return False


def is_list(content: bytes, name: str) -> bool:
    """As `is_sog_list`, of a file's content."""
    if not name.endswith(LIST):
        return False
    try:
        said: Any = parsed(content)
    except ValueError:
        return False
    return isinstance(said, dict) and ({"means", "sh0"} <= said.keys() or "lodLevels" in said)
