"""Reads a source in a thread of its own, keeps its newest frame, and takes it up again when it is lost."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Literal

from app.errors import UserError, sentence
from app.live.delays import Delays
from app.live.newest import Newest
from app.live.sources.source import Arrived, Source, SourceLost
from renderer.clip import ClipError

State = Literal["connecting", "live", "lost", "ended", "failed"]
"""Failed: what was asked for can never be shown."""
FIRST_WAIT, LONGEST_WAIT = 0.25, 2.0
"""Seconds before a lost source is tried again: twice as long each time it is not there."""

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Connection:
    """How the source stands."""

    state: State = "connecting"
    told: str = ""
    """What the source really gives, once it is there."""
    reason: str = ""
    """Why it is lost or failed."""
    frames_per_second: float | None = None
    """As the source says itself."""
    times_lost: int = 0


class Capture:
    """Begins at once, and ends by `close` or with the source."""

    def __init__(self, open_source: Callable[[], Source]) -> None:
        """open_source: called in the thread, at first and whenever the source was lost."""
        self.frames: Newest[Arrived] = Newest()
        self.connection = Connection()
        self.count = 0
        """Frames that have arrived."""
        self.missed = 0
        """Frames that the source itself left out."""
        self.unpaired = 0
        """Pairs of eyes that it left out as too far apart."""
        self.apart = Delays()
        """From one eye to the other, of two sources."""
        self._open = open_source
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="vesselsplat-capture", daemon=True)
        self._thread.start()

    @property
    def dropped(self) -> int:
        """Frames that were late somewhere between the source and the enhancement."""
        return self.frames.dropped + self.missed

    @property
    def is_over(self) -> bool:
        """No frame will come any more."""
        return self.connection.state in ("ended", "failed")

    def end(self) -> None:
        """Let go of the source, without waiting for it."""
        self._closing.set()

    def close(self, timeout: float = 3.0) -> None:
        """The same, and wait; a source that hangs for longer is left to end with the process."""
        self.end()
        self._thread.join(timeout)

    def _run(self) -> None:
        wait = FIRST_WAIT
        while not self._closing.is_set():
            before = self.count
            try:
                if self._follow():
                    self._become("ended")
                    return
            except SourceLost as error:
                self._become("lost", str(error))
            except (UserError, ClipError) as error:
                log.info("live source failed", exc_info=True)
                self._become("failed", sentence(error))
                return
            except Exception as error:
                # Drivers raise anything; the thread outlives it, and says so.
                log.info("live source failed", exc_info=True)
                self._become("lost", sentence(error))
            wait = FIRST_WAIT if self.count > before else min(2 * wait, LONGEST_WAIT)
            self._closing.wait(wait)

    def _follow(self) -> bool:
        """Read on until the source has ended, which is told by True, or all is closed."""
        source = self._open()
        try:
            while not self._closing.is_set():
                arrived = source.read()
                if arrived is None:
                    return True
                if self.connection.state != "live":
                    lost = self.connection.times_lost
                    told, rate = source.told, source.frames_per_second
                    self.connection = Connection("live", told, "", rate, lost)
                self.count += 1
                self.missed += arrived.missed
                self.unpaired += arrived.unpaired
                if arrived.apart is not None:
                    self.apart.add(arrived.apart)
                self.frames.put(arrived)
            return False
        finally:
            with suppress(Exception):
                source.close()

    def _become(self, state: State, reason: str = "") -> None:
        now = self.connection
        lost = now.times_lost + (state == "lost" and now.state == "live")
        self.connection = replace(now, state=state, reason=reason, times_lost=lost)
