"""Where windows are attacked."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

SIZE = "1280x800x24"


def screen() -> list[str]:
    """What a command is put behind to have a screen, where there is none."""
    if os.environ.get("DISPLAY") or shutil.which("xvfb-run") is None:
        return []
    return ["xvfb-run", "-a", "-s", f"-screen 0 {SIZE}"]


@contextmanager
def display() -> Iterator[str]:
    """The name of a screen for processes whose exit codes count, and which may be killed with their group."""
    if name := os.environ.get("DISPLAY"):
        yield name
        return
    command = ["Xvfb", "-displayfd", "1", "-screen", "0", SIZE]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
        assert server.stdout is not None
        try:
            yield f":{server.stdout.readline().strip()}"
        finally:
            server.terminate()
