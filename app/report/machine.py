"""The machine that a report was measured on. No host, no path."""

from __future__ import annotations

import os
import platform
import re
from pathlib import Path
from typing import Any

import psutil
from numba import get_num_threads

from app.runs.system_info import collect


def machine() -> dict[str, Any]:
    """Versions, processor, memory, driver, and the load when the measurements began."""
    known = collect()
    names = ("version", "python", "system", "cores", "packages", "opengl", "cuda_devices")
    return {name: known[name] for name in names} | {
        "processor": _processor(),
        "memory_gb": round(psutil.virtual_memory().total / 1e9, 1),
        "threads": get_num_threads(),
        "load": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
    }


def _processor() -> str:
    listing = Path("/proc/cpuinfo")
    named = re.search(r"model name\s*:\s*(.+)", listing.read_text()) if listing.exists() else None
    return named[1] if named else platform.processor() or platform.machine()
