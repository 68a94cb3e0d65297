"""Labels over a picture, as values."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

Tone = Literal["plain", "enhanced", "caution"]


@dataclass(frozen=True)
class Tag:
    """One line over a picture; the tone says how loud."""

    text: str
    tone: Tone = "plain"


def cautions(tags: Iterable[Tag]) -> tuple[Tag, ...]:
    """Those alone that keep a picture from misleading."""
    return tuple(tag for tag in tags if tag.tone == "caution")
