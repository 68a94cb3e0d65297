"""Keys as they are called on this system."""

from __future__ import annotations

import re
import sys
from typing import Final

USES: Final = r"(?=\+| subtracts\b| intersects\b)"
"""What follows a key in what the window says: another key, or what it does."""


def with_keys(text: str) -> str:
    """`text` with the keys of this system: where it says Ctrl, ImGui takes Cmd on macOS. Names of files that
    it holds stay, "Ctrl-03"."""
    return re.sub(rf"\bCtrl{USES}", "Cmd", text) if sys.platform == "darwin" else text
