"""A live session: one thread reads, one enhances, and whoever looks takes the newest picture."""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import Final

import numpy as np

from app.enhancement.methods import MethodEnhancer, load_kernels
from app.errors import sentence
from app.live.capture import Capture
from app.live.delays import Delays
from app.live.newest import Newest
from app.live.picture import EyePair, LivePicture, LiveSetting, LiveStatus, Signal
from app.live.sources.source import Arrived, Source
from enhance import LiveStatistics, Statistics
from renderer.clip import ByteImage
from renderer.readers.video_decoding.stereo_layout import eyes

STALE: Final = 0.5
"""Seconds without a picture after which the last one is not live any more."""
SLOW: Final = 2.5
"""Frames of a slow source that may be missing before."""
HALF_LIFE: Final = 0.5
"""Seconds in which statistics follow half of a change."""
LEAST_APART: Final = 1e-3
"""Seconds from one frame to the next, at least: two may arrive at once."""
USUAL_RATE: Final = 25.0
BLACK: Final = 8
"""Grey levels that no pixel of a picture without a signal passes; some grabbers give 16 for black: see
PEDESTAL."""
PEDESTAL: Final = 24
SPARSE: Final = 16
BLACK_AFTER: Final = 0.5
"""Seconds of black after which it is told."""
WINDOW: Final = 2.0
"""Seconds over which the rate is counted, or since the first picture."""
WAITING: Final = 0.1

log = logging.getLogger(__name__)
Recipient = Callable[[LivePicture], None]


@dataclass(frozen=True, kw_only=True)
class Followed(LiveStatistics):
    """As much in a second whatever the source's rate, and however many of its frames are left out."""

    apart: Callable[[], float] = lambda: 1 / USUAL_RATE
    """Seconds between the last two frames that were taken."""

    def follow(self, before: Statistics | None, measured: Statistics) -> Statistics:
        frames = HALF_LIFE / max(self.apart(), LEAST_APART)
        return LiveStatistics(half_life=frames, cut=self.cut).follow(before, measured)


class LiveSession:
    """Begins at once, and ends by `close`, or when the source has ended for good.

    The newest frame wins: nothing queues, what is late is dropped and counted.
    """

    def __init__(
        self,
        open_source: Callable[[], Source],
        setting: LiveSetting,
        *,
        on_picture: Callable[[], None] = lambda: None,
        recipients: tuple[Recipient, ...] = (),
    ) -> None:
        """on_picture: called when there is a new picture to take. recipients: are given each; they must not
        wait."""
        self.setting = setting
        """Taken over with the next frame; set it from any thread."""
        self.recipients = recipients
        self.pictures: Newest[LivePicture] = Newest()
        self._on_picture = on_picture
        self._capture = Capture(open_source)
        self._to_ready, self._to_screen = Delays(), Delays()
        self._made = 0
        self._trouble = ""
        self._last: float | None = None
        self._apart = 1 / USUAL_RATE
        self._black_since: float | None = None
        self._times: deque[float] = deque(maxlen=512)
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="vesselsplat-live", daemon=True)
        self._thread.start()

    def end(self) -> None:
        """Let go of the source, without waiting for it."""
        self._closing.set()
        self._capture.end()

    def close(self) -> None:
        """The same, and wait for the frame in hand, and no longer than a few seconds for the source."""
        self.end()
        self._capture.close()
        self._thread.join(2.0)

    @property
    def is_over(self) -> bool:
        """No picture will come any more, and all that came have been made."""
        return not self._thread.is_alive()

    def shown(self, picture: LivePicture, at: float) -> None:
        """The picture was on the screen at that time, on `time.perf_counter`, for the first time."""
        self._to_screen.add(at - picture.arrived)

    def status(self) -> LiveStatus:
        now, link = time.perf_counter(), self._capture.connection
        since = None if self._last is None else now - self._last
        signal, reason = self._signal(now, since)
        return LiveStatus(
            signal=signal,
            reason=reason,
            told=link.told,
            frames_per_second=rate_of(tuple(self._times), now),
            arrived=self._capture.count,
            made=self._made,
            dropped=self._capture.dropped,
            times_lost=link.times_lost,
            since=since,
            to_ready=self._to_ready.now,
            to_screen=self._to_screen.now,
            apart=self._capture.apart.now,
            unpaired=self._capture.unpaired,
        )

    def _signal(self, now: float, since: float | None) -> tuple[Signal, str]:
        link = self._capture.connection
        if link.state != "live":
            return link.state, link.reason
        if since is None:
            return "connecting", self._trouble
        rate = link.frames_per_second or USUAL_RATE
        if since > max(STALE, SLOW / rate):
            return "stale", self._trouble or f"no frame for {since:.1f} s"
        if self._black_since is not None and now - self._black_since > BLACK_AFTER:
            return "black", "the source gives black frames"
        return "live", ""

    def _run(self) -> None:
        numbers, enhancer, of_size = count(1), None, None
        load(self.setting)
        while not self._closing.is_set():
            # Asked first: the last frame may come with the end, just after one has waited in vain.
            is_over = self._capture.is_over
            arrived = self._capture.frames.take(WAITING)
            if arrived is None:
                if is_over:
                    return
                continue
            try:
                original, pair = _split(arrived)
                if enhancer is None or original.shape != of_size:
                    enhancer, of_size = MethodEnhancer(Followed(apart=lambda: self._apart)), original.shape
                if self._last is not None:
                    self._apart = arrived.at - self._last
                picture = _enhanced(enhancer, next(numbers), arrived, original, self.setting)
                aspect = arrived.pixel_aspect if pair is None else pair.eye_aspect
                self._deliver(replace(picture, pair=pair, pixel_aspect=aspect))
            except Exception as error:
                # Of whatever kind, as drivers give anything and memory may be short for a while: one damaged
                # frame is passed over; where all are, the picture goes stale with this reason.
                self._trouble = sentence(error)
                log.info("a live frame failed", exc_info=True)

    def _deliver(self, picture: LivePicture) -> None:
        ready = time.perf_counter()
        self._to_ready.add(ready - picture.arrived)
        self._times.append(ready)
        self._made, self._trouble, self._last = picture.number, "", picture.arrived
        if not is_black(picture.original):
            self._black_since = None
        elif self._black_since is None:
            self._black_since = ready
        self.pictures.put(picture)
        for give in self.recipients:
            give(picture)
        self._on_picture()


def load(setting: LiveSetting) -> None:
    """The kernels that frames are enhanced by, from disk or compiled, which is no time of a frame."""
    if setting.params is not None:
        load_kernels(setting.params, np.zeros((64, 64, 3), np.uint8))


def rate_of(times: Sequence[float], now: float) -> float:
    """Pictures per second, of the times of the last ones in seconds, the oldest first."""
    since_first = now - times[0] if times else 0.0
    if since_first >= WINDOW:
        return sum(now - WINDOW <= one for one in times) / WINDOW
    return (len(times) - 1) / since_first if since_first > 0 else 0.0


def is_black(image: ByteImage) -> bool:
    """Nothing is on it: all of it is black, or one dark grey as of grabbers without a signal."""
    sample = image[::SPARSE, ::SPARSE]
    top = int(sample.max(initial=0))
    return top <= BLACK or (top <= PEDESTAL and top - int(sample.min(initial=255)) <= BLACK // 2)


def _split(arrived: Arrived) -> tuple[ByteImage, EyePair | None]:
    """What is shown and enhanced of a frame. Raises ClipError: its eyes are not of one size."""
    image = arrived.read()
    if arrived.stereo is None:
        return image, None
    left, _ = eyes(image, arrived.stereo)
    return np.ascontiguousarray(left), EyePair(image, arrived.stereo, arrived.pixel_aspect)


def _enhanced(
    enhancer: MethodEnhancer, number: int, arrived: Arrived, original: ByteImage, setting: LiveSetting
) -> LivePicture:
    start = time.perf_counter()
    if setting.params is None:
        return LivePicture(number, arrived.at, original, None, setting, None, (), 0.0)
    enhancer.show(original, pixels=setting.pixels)
    result = enhancer.enhance(setting.params)
    spent = 1000 * (time.perf_counter() - start)
    image = np.asarray(result.image, np.uint8)
    used = result.statistics
    return LivePicture(number, arrived.at, original, image, setting, used, result.omitted, spent)
