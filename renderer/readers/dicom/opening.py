"""DICOM files are known by their mark and opened here alone, where pydicom is installed."""

from __future__ import annotations

import io
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Final

from renderer.clip import ClipError
from renderer.regular_files import require_regular

SUFFIXES: Final = frozenset({".dcm", ".dicom"})
NO_PYDICOM: Final = (
    "a DICOM file needs pydicom, which is not part of this bundle (see Start in the README)"
    if getattr(sys, "frozen", False)
    else "a DICOM file needs pydicom: pip install pydicom"
)
LONGEST: Final = 200
"""Characters of what pydicom says."""
PREAMBLE, MARK = 128, b"DICM"


def is_dicom(path: Path) -> bool:
    """Whether a file, of any name, bears the mark of DICOM."""
    try:
        # Files of a system's state, such as /proc/kmsg, are empty by their size, and reading them may wait.
        if require_regular(path) < PREAMBLE + len(MARK):
            return False
        with path.open("rb") as file:
            return file.read(PREAMBLE + len(MARK))[PREAMBLE:] == MARK
    except OSError:
        return False


def has_pydicom() -> bool:
    """Without loading it."""
    return find_spec("pydicom") is not None


class _File(io.BufferedReader):
    """A file that is asked for no more than it holds: a damaged length would reserve gigabytes."""

    def __init__(self, path: Path) -> None:
        self.length = require_regular(path)
        super().__init__(io.FileIO(path))

    def read(self, size: int | None = -1) -> bytes:
        left = max(self.length - self.tell(), 0)
        return super().read(left if size is None or size < 0 else min(size, left))


@contextmanager
def opened_dicom(path: Path) -> Iterator[io.BufferedReader]:
    """The file for pydicom, whose errors of any kind become one line.

    Raises:
        ClipError: pydicom is not installed, or what is read in the block is damaged.
    """
    if not has_pydicom():
        raise ClipError(f"{NO_PYDICOM} ({path.name})")
    try:
        # pydicom warns of every rule that a file breaks, and reads on.
        with _File(path) as file, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield file
    except ClipError:
        raise
    # Headers that make no sense raise whatever their values run into.
    except Exception as error:
        said = " ".join(str(error).split())[:LONGEST] or type(error).__name__
        raise ClipError(f"expected an intact DICOM file, got a damaged one ({said}): {path}") from error
