"""Where windows are attacked."""

from __future__ import annotations

import os
import shutil


def screen() -> list[str]:
    """What a command is put behind to have a screen, where there is none."""
    if os.environ.get("DISPLAY") or shutil.which("xvfb-run") is None:
        return []
    return ["xvfb-run", "-a", "-s", "-screen 0 1280x800x24"]
