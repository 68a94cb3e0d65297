"""What is said of a video that ends before its header says."""

from __future__ import annotations

from typing import Final

CUT_OFF: Final = "the file is cut off or damaged at its end"
"""How the notice begins, by which it is known."""
