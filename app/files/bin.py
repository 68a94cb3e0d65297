"""The system's bin, from which a person has back what was deleted: whether there is one, and moving there."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from app.errors import UserError

LOCAL_DISK = 3
"""As Windows calls it; it has no bin for others, of networks and of sticks."""


def has_bin(path: Path) -> bool:
    """Whether what lies there can be moved to a bin. Raises OSError: nothing that can be looked at does."""
    if sys.platform == "win32":
        import ctypes

        return ctypes.windll.kernel32.GetDriveTypeW(str(Path(path.absolute().anchor))) == LOCAL_DISK
    if sys.platform == "darwin":
        return True
    return any(map(_can_be_made, _bins(path.absolute())))


def move_to_bin(path: Path) -> None:
    """A file or a folder with all that lies in it. Raises UserError or OSError: it stays where it is."""
    # Its import settles where the bin is.
    from send2trash import send2trash
    from send2trash.exceptions import TrashPermissionError

    try:
        send2trash(path)
    except TrashPermissionError as error:
        raise UserError(f"the system has no bin for {path}") from error


def _bins(path: Path) -> list[Path]:
    """Where the freedesktop.org specification has them: in a person's home, or on the drive of `path`."""
    if path.lstat().st_dev == Path.home().stat().st_dev:
        return [Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share") / "Trash"]
    top, user = next(one for one in path.parents if one.is_mount()), os.getuid()
    shared = top / ".Trash"
    return [top / f".Trash-{user}", *([shared / str(user)] if shared.is_dir() else [])]


def _can_be_made(folder: Path) -> bool:
    """Whether a folder is there and writable, or could be made."""
    found = next(one for one in (folder, *folder.parents) if one.exists())
    return found.is_dir() and os.access(found, os.W_OK | os.X_OK)
