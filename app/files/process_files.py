"""Files that each process of the app keeps for itself, and those that dead processes have left.

Named `KIND-PROCESS.MOMENT-MACHINE-TOKEN`; former versions left out the moment when the process began, or
named them `KIND-PROCESS`.
"""

from __future__ import annotations

import os
import re
import secrets
import time
from pathlib import Path
from typing import Final

import psutil

from renderer.leftovers import lives, machine, machines, mark_of

TOKEN: Final = secrets.token_hex(4)
"""Of this process: its number comes again, in a container with each start."""
FORGOTTEN: Final = 7 * 24 * 3600.0
"""Seconds; after them a file of another machine, whose processes cannot be seen, is one that was left."""
_NAME: Final = re.compile(r"(\d+)(\.\d+)?(?:-([0-9a-f]{8})-[0-9a-f]{8})?")


def own_file(folder: Path, kind: str, suffix: str) -> Path:
    """Where this process keeps its file of this kind."""
    return folder / f"{kind}-{mark_of(os.getpid())}-{machine()}-{TOKEN}{suffix}"


def left_behind(folder: Path, kind: str, suffix: str) -> list[Path]:
    """Those of processes that have ended, the oldest first. Raises OSError: the folder cannot be listed."""
    own = own_file(folder, kind, suffix)
    files = (path for path in folder.glob(f"{kind}-*{suffix}") if path != own)
    left = [path for path in files if not _is_written_still(path, kind)]
    return sorted(left, key=_written)


def claimed(folder: Path, kind: str, suffix: str) -> list[Path]:
    """Those of processes that have ended, the oldest first, renamed as files of this one: each goes to one
    process, and one that ends before it is done leaves them to the next.
    Raises OSError: the folder cannot be listed, or a file not be renamed.
    """
    return [path for left in left_behind(folder, kind, suffix) if (path := _claim(left, kind)) is not None]


def _claim(left: Path, kind: str) -> Path | None:
    name = f"{kind}-{mark_of(os.getpid())}-{machine()}-{secrets.token_hex(4)}{left.suffix}"
    try:
        return left.rename(left.with_name(name))
    except FileNotFoundError:
        return None


def _written(path: Path) -> float:
    """When the file was written; long ago where another process has just removed it."""
    try:
        return path.stat().st_mtime
    except FileNotFoundError:
        return 0.0


def _is_written_still(path: Path, kind: str) -> bool:
    """Its process lives, and is not a later one of the same number."""
    found = _NAME.fullmatch(path.stem.removeprefix(f"{kind}-"))
    if found is None:
        return True
    try:
        written = path.stat().st_mtime
        if found[3] and found[3] not in machines():
            return time.time() - written < FORGOTTEN
        process = int(found[1])
        if process == os.getpid():
            return False
        if found[2]:
            return lives(found[1] + found[2])
        return float(psutil.Process(process).create_time()) <= written
    except (psutil.Error, OSError, OverflowError):
        return False
