"""When the window begins a frame while it shows a live source."""

from __future__ import annotations

from typing import Final

from app.gui.state.live import Live

SPARE: Final = 1.5
"""How much longer than the frames before it a frame may take."""
LONGEST: Final = 0.1
"""Seconds that the answer to a hand waits for a picture at most."""


def wait_for_picture(live: Live, now: float) -> float:
    """Seconds to wait for the next picture before a frame is begun.

    A frame that would still be drawn when the next picture arrives would hold it up: that one is waited for
    and shown with it, together with all that the hand has done meanwhile. Quick hardware waits for none.
    """
    status, newest = live.status, live.newest
    if not live.flows or newest is None or status is None or not status.frames_per_second:
        return 0.0
    interval = 1 / status.frames_per_second
    left = newest.arrived + interval - now
    return 0.0 if SPARE * live.drawing.seconds < left else min(max(left, 0.0) + interval, LONGEST)
