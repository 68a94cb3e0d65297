"""When a file was made, as part of its name."""

from __future__ import annotations

from datetime import datetime


def stamp() -> str:
    """Local time to the millisecond: names sort as they were made, and two in a second differ."""
    return datetime.now().astimezone().strftime("%Y%m%d-%H%M%S-%f")[:-3]
