"""When the frames of a video are shown."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Timing:
    """When frames are shown, and the video that they come from."""

    frames_per_second: float
    frame_times: tuple[float, ...] | None = None
    """Seconds, rising, where frames do not come evenly."""
    start: float = 0.0
    """Seconds from the first frame of `like` to the first that is written."""
    like: Path | None = None
    """The video that frames are made from, one for one; sound, colour tags and shape of pixels are kept."""
    has_sound: bool = True
    """Whether the sound is."""


def losses(timing: Timing) -> tuple[str, ...]:
    """A sentence for each thing that a writer of even, silent frames leaves out."""
    lost = ["sound is"] if timing.like is not None and timing.has_sound else []
    lost += [] if timing.frame_times is None else ["uneven frame times are"]
    return tuple(f"{what} not kept: this needs PyAV, which is not installed" for what in lost)
