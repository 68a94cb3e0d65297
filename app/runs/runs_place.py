"""Where the window keeps this user's runs."""

from __future__ import annotations

import os
from pathlib import Path

import platformdirs


def runs_place() -> Path:
    """The platform's own folder for data; VESSELSPLAT_RUNS_DIR overrides it."""
    own = platformdirs.user_data_path("vesselsplat", False) / "runs"
    return Path(os.environ.get("VESSELSPLAT_RUNS_DIR") or own)
