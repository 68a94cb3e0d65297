"""Commands of this program as lines to copy into a shell."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from typing import Final

PLAIN: Final = re.compile(r"[\w.:/\\-]+")
"""What no shell of Windows reads in a way of its own."""


def command(*words: object) -> str:
    """A line that a shell takes as it stands."""
    line = ["vesselsplat", *map(str, words)]
    return " ".join(map(_for_windows, line)) if sys.platform == "win32" else shlex.join(line)


def _for_windows(word: str) -> str:
    quoted = subprocess.list2cmdline([word])
    return quoted if quoted != word or PLAIN.fullmatch(word) else f'"{word}"'
