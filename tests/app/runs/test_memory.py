"""Memory that was freed goes back to the system."""

from __future__ import annotations

import sys

import psutil
import pytest

from app.runs.memory import give_back

PIECE = 8192
PIECES = 20_000


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere the C library does so by itself")
def test_what_was_freed_between_what_is_kept_goes_back() -> None:
    """The C library alone gives back only what lies beyond all that is kept."""
    pieces = [bytearray(PIECE) for _ in range(PIECES)]
    pieces[:-1] = [bytearray() for _ in pieces[:-1]]
    before = psutil.Process().memory_info().rss
    give_back()
    freed = before - psutil.Process().memory_info().rss
    assert freed > 0.5 * PIECE * PIECES
    assert len(pieces[-1]) == PIECE
