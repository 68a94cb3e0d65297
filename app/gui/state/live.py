"""What is live: the source, the pictures that come from it, what is recorded. A part of the state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, Literal

from app.gui.work.live_devices import Found
from app.live.address import LiveInput
from app.live.igtl.endpoint import Endpoint
from app.live.igtl.sender import Sender, Sending
from app.live.picture import LivePicture, LiveStatus
from app.live.recorder import Recorder, Recording, What
from app.live.session import LiveSession, Recipient
from app.live.sources.source import Wish
from renderer.clip import Clip

SIZES: Final[Mapping[tuple[int, int] | None, str]] = {
    None: "as delivered",
    (720, 576): "720 × 576",
    (1280, 720): "1280 × 720",
    (1920, 1080): "1920 × 1080",
    (3840, 2160): "3840 × 2160",
}
RATES: Final[Mapping[float | None, str]] = {
    None: "as delivered",
    25.0: "25",
    30.0: "30",
    50.0: "50",
    60.0: "60",
}


Eyes = Literal["auto", "side-by-side", "top-bottom", "two"]
EYES: Final[Mapping[Eyes, str]] = {
    "auto": "as delivered",
    "side-by-side": "side by side",
    "top-bottom": "one above the other",
    "two": "from two sources",
}
"""Where the eyes of a stereo source are."""

NEWEST_SHARE: Final = 0.1
"""Of the newest frame in how long frames take."""


@dataclass
class LiveChoice:
    """The dialog that asks for a source."""

    shown: bool = False
    text: str = ""
    """Address that is typed."""
    wish: Wish = field(default_factory=Wish)
    eyes: Eyes = "auto"
    right: str = ""
    """Address of the right eye's source, as typed."""
    found: Found | None = None
    """The devices, once they are listed."""
    looks: int = 0
    """How often they were asked for."""
    trouble: str = ""
    """Why the typed address is none."""


@dataclass
class Drawing:
    """How long frames of the window take."""

    began: float | None = None
    """When the one that is drawn now was begun, on `time.perf_counter`."""
    seconds: float = 0.0
    """Of the last ones, the newest counting most."""

    def end(self, now: float) -> None:
        if self.began is not None:
            self.seconds += NEWEST_SHARE * (now - self.began - self.seconds)
        self.began = None


@dataclass
class Live:
    """Live actions change it, and the update, which follows the session; drawing reads it."""

    choice: LiveChoice = field(default_factory=LiveChoice)
    asked: tuple[LiveInput, Wish] | None = None
    """What is to be live from the next frame on."""
    leaving: bool = False
    """It is to end with the next frame."""
    source: LiveInput | None = None
    session: LiveSession | None = None
    clip: Clip | None = None
    """Stands for the newest picture among what is open; None until there is one."""
    still: Clip | None = None
    """The frozen frame; None while the pictures follow the source."""
    newest: LivePicture | None = None
    drawing: Drawing = field(default_factory=Drawing)
    unshown: LivePicture | None = None
    """It will be on screen with the next swap."""
    status: LiveStatus | None = None
    recorder: Recorder | None = None
    what: What = "original"
    """Is recorded."""
    completing: tuple[Recorder, ...] = ()
    """Recordings that were ended and still write."""
    endpoint: Endpoint = field(default_factory=Endpoint)
    """Where others may fetch the pictures."""
    send_asked: bool = False
    """It is to be sent as soon as it is live."""
    sender: Sender | None = None
    told: str = ""
    """The trouble that was told last, which is told once."""

    @property
    def flows(self) -> bool:
        """Pictures on screen come from the source, not from a clip."""
        return self.session is not None and self.clip is not None and self.still is None

    @property
    def connects(self) -> bool:
        """Nothing has come yet."""
        return self.asked is not None or (self.session is not None and self.clip is None)

    def stop_connecting(self) -> None:
        """What has not given a frame yet is waited for no longer."""
        if self.connects:
            self.asked, self.leaving = None, self.session is not None

    @property
    def recording(self) -> Recording | None:
        """How far it is; None where nothing is recorded."""
        return self.recorder.state if self.recorder is not None else None

    @property
    def sending(self) -> Sending | None:
        """How it stands; None where nothing is sent."""
        return self.sender.state if self.sender is not None else None

    @property
    def recipients(self) -> tuple[Recipient, ...]:
        """Are given every picture."""
        return tuple(one.add for one in (self.recorder, self.sender) if one is not None)
