"""Files that are opened are regular ones: a pipe, a socket or a device would hang whoever reads it."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

MOST_BYTES = 1 << 28
"""Of a file of text. The cameras of 100,000 frames take 60 MB, the poses of a million frames less."""
KINDS = {
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFDIR: "a folder",
}


def require_regular(path: Path) -> int:
    """The size in bytes of a regular file; links are followed.

    Raises:
        OSError: there is none, or it is something else; its text says what.
    """
    found = path.stat()
    if not stat.S_ISREG(found.st_mode):
        kind = what_else(path)
        number = errno.EISDIR if kind == "a folder" else errno.EINVAL
        raise OSError(number, f"expected a file, got {kind}", str(path))
    return found.st_size


def require_file_or_folder(path: Path) -> None:
    """Raises OSError, which names it: it is neither, or a folder whose files may not be looked at."""
    if not stat.S_ISDIR(path.stat().st_mode):
        require_regular(path)
    elif not os.access(path, os.R_OK | os.X_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))


def what_else(path: Path) -> str:
    """The kind of what lies under a name and is no regular file. Raises OSError: nothing is there."""
    return KINDS.get(stat.S_IFMT(path.stat().st_mode), "something else")


def read_whole(path: Path) -> bytes:
    """The content of a regular file of any size. Raises OSError: it cannot be read, or is something else."""
    require_regular(path)
    with _named(path):
        return path.read_bytes()


def read_regular(path: Path, most: int = MOST_BYTES) -> bytes:
    """The content of a regular file of at most that many bytes.

    Raises:
        OSError: it cannot be read, is no regular file, or is larger.
    """
    size = require_regular(path)
    if size > most:
        expected = f"expected at most {_megabytes(most)}, got {_megabytes(size)}"
        raise OSError(errno.EFBIG, expected, str(path))
    with _named(path), path.open("rb") as file:
        content = file.read(most + 1)
    # A file may grow while it is read.
    if len(content) > most:
        raise OSError(errno.EFBIG, f"expected at most {_megabytes(most)}, got more", os.fspath(path))
    return content


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """Errors that come while a file is read, as of a disk that fails, name it; the system does not."""
    try:
        yield
    except OSError as error:
        if error.filename is not None:
            raise
        raise OSError(error.errno, error.strerror, os.fspath(path)) from error


def _megabytes(size: int) -> str:
    return f"{size / 1e6:.0f} MB"
