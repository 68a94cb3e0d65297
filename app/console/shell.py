"""Commands of this program as lines to copy into a shell."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Final

PLAIN: Final = re.compile(r"[\w.:/\\-]+")
"""What no shell of Windows reads in a way of its own."""


def command(*words: object) -> str:
    """A line that a shell takes as it stands; no path in it reads as a flag."""
    line = ["vesselsplat", *map(_word, words)]
    return " ".join(map(_for_windows, line)) if sys.platform == "win32" else shlex.join(line)


def _word(word: object) -> str:
    is_flag_like = isinstance(word, Path) and str(word).startswith("-")
    return f"{os.curdir}{os.sep}{word}" if is_flag_like else str(word)


def _for_windows(word: str) -> str:
    quoted = subprocess.list2cmdline([word])
    return quoted if quoted != word or PLAIN.fullmatch(word) else f'"{word}"'
