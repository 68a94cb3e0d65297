"""Files that ship with the program."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path


def phantom_path() -> Path:
    """The embedded phantom clip in EndoNeRF layout: `PhantomParams(seed=3, noise=0.3)`."""
    return _folder("phantom")


def guide_path() -> Path:
    """The pages of the guide, Markdown, with their images."""
    return _folder("guide")


def welcome_path() -> Path:
    """The images of the window's first page."""
    return _folder("welcome")


def _folder(name: str) -> Path:
    return Path(str(files("assets"))) / name
