"""What is said of a video that ends before its header says."""

from __future__ import annotations

from typing import Final

CUT_OFF: Final = "the file is cut off or damaged at its end"
"""How the notice begins, by which it is known."""


def cut_off(whole: int, announced: int = 0) -> str:
    """Of a file of which so many frames are whole; `announced`: how many its header tells, 0: it does not."""
    of_all = f" of {announced}" if announced > whole else ""
    return f"{CUT_OFF}: {whole}{of_all} frames are whole"
