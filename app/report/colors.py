"""Colours of lines in diagrams: Okabe and Ito's, which colour-blind viewers tell apart."""

from __future__ import annotations

from typing import Final

COLORS: Final = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f", "#000000")
