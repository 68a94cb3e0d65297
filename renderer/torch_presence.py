"""Whether torch is installed. Only autograd, the float64 oracle, LPIPS and GPUs need it."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from typing import Final

NO_TORCH: Final = (
    "torch is not part of this bundle (see Start in the README)"
    if getattr(sys, "frozen", False)
    else "torch is not installed (pip install torch)"
)


def has_torch() -> bool:
    """Without loading it."""
    return find_spec("torch") is not None
