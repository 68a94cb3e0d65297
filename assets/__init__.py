"""Files that ship with the program."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path


def phantom_path() -> Path:
    """The embedded phantom clip in EndoNeRF layout: `PhantomParams(seed=3, noise=0.3)`."""
    return Path(str(files("assets"))) / "phantom"
