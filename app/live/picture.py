"""What a live session makes of a frame, and how it stands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from app.enhancement.methods import EnhancementSettings
from app.live.delays import Delay
from enhance import Statistics
from enhance.result import Omission
from enhance.shown import Named
from renderer.clip import ByteImage
from renderer.readers.clip_options import StereoLayout
from renderer.readers.video_decoding.stereo_layout import eye_aspect, eye_size

LIVE: Final = "live"
"""Format of a clip that stands for a live source, or for a frame of it."""
FRAME: Final = "live frame"
RECORDING: Final = "live recording"
"""Kinds of files that were recorded as they came: nothing makes them again."""


@dataclass(frozen=True)
class LiveSetting:
    """How frames are enhanced from now on. None: they are shown as they come."""

    params: EnhancementSettings | None
    pixels: Named = "automatic"


@dataclass(frozen=True, eq=False)
class EyePair:
    """A frame with both eyes, as it came."""

    image: ByteImage
    """(H, W, 3) RGB."""
    layout: StereoLayout
    pixel_aspect: float = 1.0
    """Width of a pixel by its height, as the source says."""

    @property
    def eye_aspect(self) -> float:
        """The same of each eye, which may come squeezed."""
        height, width = self.image.shape[:2]
        return eye_aspect(eye_size((width, height), self.layout), self.layout, self.pixel_aspect)


@dataclass(frozen=True, eq=False)
class LivePicture:
    """One frame, original and enhanced."""

    number: int
    """Of the frames that were enhanced in this session, from 1."""
    arrived: float
    """On `time.perf_counter`."""
    original: ByteImage
    """(H, W, 3) RGB; of both eyes, the left one's."""
    enhanced: ByteImage | None
    """None: white light was asked for."""
    setting: LiveSetting
    statistics: Statistics | None
    omitted: tuple[Omission, ...]
    milliseconds: float
    """Of the enhancement alone."""
    pair: EyePair | None = None
    """Where the frame held both eyes."""
    pixel_aspect: float = 1.0
    """Width of a pixel of the original by its height."""


Signal = Literal["connecting", "live", "black", "stale", "lost", "ended", "failed"]
"""Stale: no new picture for half a second. Black: pictures come, with nothing on them."""


@dataclass(frozen=True)
class LiveStatus:
    """How a session stands at a moment."""

    signal: Signal
    reason: str
    """Why there is no live picture, in one line; empty where there is one."""
    told: str
    """What the source really gives."""
    frames_per_second: float
    """Pictures that were made of late, a second; 0 where none was."""
    arrived: int
    """Frames of the source."""
    made: int
    """Pictures."""
    dropped: int
    """Frames that were late for the enhancement and have been left out."""
    times_lost: int
    since: float | None
    """Seconds since the newest picture arrived; None before the first."""
    to_ready: Delay | None
    """From arrival to enhanced."""
    to_screen: Delay | None
    """From arrival to the swap that showed it; None without a screen."""
    apart: Delay | None = None
    """From the arrival of one eye to that of the other; None but for two sources."""
    unpaired: int = 0
    """Pairs of eyes that have been left out, more than half a frame apart."""

    @property
    def is_live(self) -> bool:
        return self.signal == "live"
