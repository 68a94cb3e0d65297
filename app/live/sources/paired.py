"""Two sources as one: frames of the left and of the right eye that are of one moment, side by side."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import Final

import numpy as np

from app.errors import UserError, sentence
from app.live.sources.pairing import Pair, Pairing
from app.live.sources.source import Arrived, Source, SourceLost
from renderer.clip import ByteImage, ClipError

EYES: Final = ("left", "right")
SILENCE: Final = 2.0
"""Seconds without a frame of an eye, or without a pair, after which the source is lost."""
SLOW: Final = 2.5
"""Frames of slow eyes that may be missing before."""
LOOK: Final = 0.1
"""Seconds after which it looks whether an eye is silent."""
CLOSING: Final = 0.5
"""Seconds that an eye may take to let go of its source before it is opened anew."""

OpenSource = Callable[[], Source]
Came = Arrived | Exception | None
"""A frame, or why there will be none, or the end."""


class PairedSource:
    """Reads each eye in a thread of its own, as neither is to wait for the other."""

    def __init__(self, opens: tuple[OpenSource, OpenSource], names: tuple[str, str]) -> None:
        """Of the left eye and of the right one; names: what is said of them."""
        self._names = names
        self._pairing = Pairing()
        self._came: SimpleQueue[tuple[int, Came]] = SimpleQueue()
        self._closing = threading.Event()
        self._opened = threading.Barrier(len(EYES))
        self._sources: dict[int, Source] = {}
        self._seen: dict[str, float] = {}
        self._is_checked = False
        self._threads = [
            threading.Thread(
                target=self._follow, args=(eye, one), name=f"vesselsplat-{EYES[eye]}", daemon=True
            )
            for eye, one in enumerate(opens)
        ]
        for thread in self._threads:
            thread.start()

    @property
    def told(self) -> str:
        left, right = (self._sources[eye].told for eye in range(2))
        return f"two sources, each {left}" if left == right else f"left {left}; right {right}"

    @property
    def frames_per_second(self) -> float | None:
        rates = [self._sources[eye].frames_per_second for eye in range(2)]
        return min((rate for rate in rates if rate is not None), default=None)

    def read(self) -> Arrived | None:
        """The next pair.

        Raises:
            SourceLost: one eye is lost, or no two frames are of one moment.
            UserError: they are of two sizes, or one eye can never be shown.
        """
        while True:
            try:
                eye, came = self._came.get(timeout=LOOK)
            except Empty:
                self._require_frames()
                continue
            if came is None:
                return None
            if isinstance(came, Exception):
                raise _of_eye(eye, came) from came
            pair = self._pairing.add(eye, came)
            self._seen[EYES[eye]] = time.perf_counter()
            if pair is not None:
                self._seen["pair"] = time.perf_counter()
                self._require_one_size(pair)
                return _arrived(pair)
            self._require_frames()

    def close(self) -> None:
        self._closing.set()
        self._opened.abort()
        for thread in self._threads:
            thread.join(CLOSING)

    def _follow(self, eye: int, opens: OpenSource) -> None:
        source: Source | None = None
        try:
            source = self._sources[eye] = opens()
            # Two files start together, as their clocks begin with the first frame that is read.
            self._opened.wait()
            while not self._closing.is_set():
                arrived = source.read()
                self._came.put((eye, arrived))
                if arrived is None:
                    return
        except Exception as error:
            # Drivers raise anything; whoever reads says so.
            self._came.put((eye, error))
            self._opened.abort()
        finally:
            if source is not None:
                with suppress(Exception):
                    source.close()

    def _require_frames(self) -> None:
        """From the first frame of each on: how long opening may take, the sources know themselves.

        Raises SourceLost: an eye has given none for too long, or there was no pair for as long.
        """
        if any(eye not in self._seen for eye in EYES):
            return
        now, patience = time.perf_counter(), max(SILENCE, SLOW * self._pairing.frame)
        for eye, name in zip(EYES, self._names, strict=True):
            if now - self._seen[eye] > patience:
                raise SourceLost(f"{eye} eye: no frame from {name} for {patience:.0f} s")
        if now - self._seen.setdefault("pair", now) > patience:
            apart = 1000 * (self._pairing.apart or 0.0)
            raise SourceLost(f"no two frames of the eyes within half a frame, the last {apart:.0f} ms apart")

    def _require_one_size(self, pair: Pair) -> None:
        """Raises UserError: of the first pair."""
        if self._is_checked:
            return
        left, right = (_size(one.read()) for one in (pair.left, pair.right))
        if left != right:
            first, second = self._names
            raise UserError(
                f"expected two eyes of one size, got {left} from {first} and {right} from {second}"
            )
        self._is_checked = True


def _arrived(pair: Pair) -> Arrived:
    return Arrived(
        lambda: _beside(pair.left.read(), pair.right.read()),
        max(pair.left.at, pair.right.at),
        pair.left.seconds,
        pair.late,
        "side-by-side",
        pair.apart,
        pair.unpaired,
        pair.left.pixel_aspect,
    )


def _beside(left: ByteImage, right: ByteImage) -> ByteImage:
    """Raises UserError: one has another size now."""
    if left.shape != right.shape:
        raise UserError(f"expected two eyes of one size, got {_size(left)} and {_size(right)}")
    return np.concatenate((left, right), axis=1)


def _size(image: ByteImage) -> str:
    return f"{image.shape[1]}x{image.shape[0]}"


def _of_eye(eye: int, error: Exception) -> Exception:
    """The same, with the eye's name."""
    said = f"{EYES[eye]} eye: {sentence(error)}"
    return UserError(said) if isinstance(error, UserError | ClipError) else SourceLost(said)
