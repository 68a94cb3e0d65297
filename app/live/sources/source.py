"""What every live source gives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from renderer.clip import ByteImage
from renderer.readers.clip_options import StereoLayout


class SourceLost(Exception):
    """The source gives no more pictures for now, and why, in one line; it may come back."""


@dataclass(frozen=True)
class Wish:
    """What a source is asked for; it may give something else. None: as it comes."""

    size: tuple[int, int] | None = None
    """Width and height in pixels."""
    frames_per_second: float | None = None
    pixel_format: str | None = None
    """Of a device, as four letters: MJPG, YUYV."""
    loop: bool = True
    """A file begins anew at its end."""


@dataclass(frozen=True, eq=False)
class Arrived:
    """One frame as it came."""

    read: Callable[[], ByteImage]
    """(H, W, 3) RGB; of frames that nobody looks at it is never made. Raises SourceLost or ClipError."""
    at: float
    """When it arrived, on `time.perf_counter`."""
    seconds: float
    """When it was taken, on the source's own clock; from any start."""
    missed: int = 0
    """Frames that came between the one before and this one, and were left out as late."""
    stereo: StereoLayout | None = None
    """How both eyes lie in it; None: it is of one."""
    apart: float | None = None
    """Seconds from the arrival of one eye to that of the other, where they come from two sources."""
    unpaired: int = 0
    """Pairs that were too far apart since the one before, and were left out."""
    pixel_aspect: float = 1.0
    """Width of a pixel by its height, as the source says; of both eyes, in all of the frame."""


class Source(Protocol):
    """Read by one thread. It is given back by `close`, also when it is lost."""

    @property
    def told(self) -> str:
        """What it really gives: size, rate and format, in a line."""

    @property
    def frames_per_second(self) -> float | None:
        """As the source reports it; None: it does not."""

    def read(self) -> Arrived | None:
        """The next frame, waiting for it; None where the source has ended for good.

        Raises:
            SourceLost: no frame came in time, or none will.
        """

    def close(self) -> None: ...
