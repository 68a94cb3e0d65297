"""How a sweep's folder is known, without loading what runs one."""

from __future__ import annotations

from pathlib import Path
from typing import Final

SWEEP: Final = "sweep.json"
"""In a sweep's folder: which jobs it has, in order."""


def is_sweep(path: Path) -> bool:
    return (path / SWEEP).is_file()
