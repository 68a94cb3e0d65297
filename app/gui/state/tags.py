"""What is said over a picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Tone = Literal["plain", "enhanced", "caution"]


@dataclass(frozen=True)
class Tag:
    """One line over a picture; the tone says how loud."""

    text: str
    tone: Tone = "plain"
