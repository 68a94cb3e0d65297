"""Keys as they are called on this system."""

from __future__ import annotations

import re
import sys


def with_keys(text: str) -> str:
    """`text` with the keys of this system: where it says Ctrl, ImGui takes Cmd on macOS."""
    return re.sub(r"\bCtrl\b", "Cmd", text) if sys.platform == "darwin" else text
