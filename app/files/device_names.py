"""Names of devices, which Windows up to 10 gives to no file, whatever suffix follows."""

from __future__ import annotations

import re
from typing import Final

_DEVICE: Final = re.compile(r"(con|prn|aux|nul|(com|lpt)[0-9¹²³]) *(\..*)?", re.IGNORECASE | re.DOTALL)


def is_device(name: str) -> bool:
    """Whether the last part of a path names a device instead of a file, as on Windows."""
    return _DEVICE.fullmatch(name) is not None
