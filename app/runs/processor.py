"""The name and the load of the CPU."""

from __future__ import annotations

import os
import platform
import re
from pathlib import Path


def processor_name() -> str:
    """As Linux lists it, else as Python knows it."""
    listing = Path("/proc/cpuinfo")
    named = re.search(r"model name\s*:\s*(.+)", listing.read_text()) if listing.exists() else None
    return named[1] if named else platform.processor() or platform.machine()


def load_average() -> float | None:
    """Over the last minute; None where the system keeps none, as Windows."""
    try:
        return os.getloadavg()[0]
    except (AttributeError, OSError):
        return None
