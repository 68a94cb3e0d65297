"""Files that each process of the app keeps for itself, and those that dead processes have left."""

from __future__ import annotations

import os
from pathlib import Path

import psutil


def own_file(folder: Path, kind: str, suffix: str) -> Path:
    """Where this process keeps its file of this kind."""
    return folder / f"{kind}-{os.getpid()}{suffix}"


def left_behind(folder: Path, kind: str, suffix: str) -> list[Path]:
    """Those of processes that have ended, the oldest first. Raises OSError: the folder cannot be listed."""
    left = [path for path in folder.glob(f"{kind}-*{suffix}") if not _is_written_still(path, kind)]
    return sorted(left, key=lambda path: path.stat().st_mtime)


def _is_written_still(path: Path, kind: str) -> bool:
    """Its process lives, and is not a later one of the same number."""
    number = path.stem.removeprefix(f"{kind}-")
    if not number.isdecimal():
        return True
    try:
        return float(psutil.Process(int(number)).create_time()) <= path.stat().st_mtime
    except (psutil.Error, OSError, OverflowError):
        return False
