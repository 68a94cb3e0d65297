"""Work before the first step of a training, done in a thread of its own while it is told how far it is."""

from __future__ import annotations

import ctypes
import threading
import time
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Future, wait
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from renderer.clip import Clip, ClipError, Frame, numbered
from renderer.train.events import Preparing
from renderer.train.frame_store import FrameStore
from renderer.train.windows import Window

SECONDS_BETWEEN = 0.5
STAGES = {"stereo": "matching left and right images", "brightness": "estimating depth from brightness"}
"""What reading frames is, by where their depth comes from."""
PROBED = 3
"""Pairs that are matched before all others, to see that anything matches, of clips of more."""

Result = TypeVar("Result")
Tell = Callable[[int, int], None]
"""Called with how much is done, and of how much."""


def told_meanwhile(stage: str, work: Callable[[Tell], Result]) -> Generator[Preparing, None, Result]:
    """The result of `work`; twice a second how far it is. Work that is quick says nothing.

    Raises what the work raises. Closed or interrupted before its end, it ends the work.
    """
    began = time.monotonic()
    told = (0, 0, began)

    def tell(done: int, total: int) -> None:
        nonlocal told
        told = (done, total, time.monotonic())

    outcome: Future[Result] = Future()
    thread = threading.Thread(target=_work, args=(work, tell, outcome), daemon=True)
    thread.start()
    try:
        while not wait([outcome], SECONDS_BETWEEN).done:
            passed = time.monotonic() - began
            done, total, when = told
            ahead = (when - began) / done * (total - done) if done else None
            left = None if ahead is None else max(ahead - (began + passed - when), 0.0)
            yield Preparing(stage, done, total, passed, left)
    finally:
        # Stopped at its next line of Python, unless it has ended: a process must not go while a decoder or a
        # kernel works in a thread.
        if thread.is_alive() and not outcome.done():
            number = ctypes.c_ulong(thread.ident or 0)
            ctypes.pythonapi.PyThreadState_SetAsyncExc(number, ctypes.py_object(_Ended))
        thread.join()
    return outcome.result()


class _Ended(BaseException):
    """Nobody waits for the work any more."""


def _work(work: Callable[[Tell], Result], tell: Tell, outcome: Future[Result]) -> None:
    try:
        outcome.set_result(work(tell))
    except BaseException as error:
        if not outcome.done():
            outcome.set_exception(error)


class ReadAhead:
    """A clip whose training frames are read once, before training, and then handed over; of a long clip those
    of the window that is trained first.

    Those that memory cannot hold lie in a file of no name in `folder` meanwhile.
    """

    def __init__(self, clip: Clip, folder: Path, window: Window) -> None:
        self.clip = replace(clip, read_frame=self._read)
        self._source, self._store, self._handing = clip, FrameStore[Frame](folder), False
        self._indices = tuple(index for index in clip.train_indices if window.first <= index <= window.last)
        self._places: dict[int, int] = {}

    def fill(self, told: Tell) -> None:
        """Raises ClipError: a frame cannot be read, or none of a few pairs that are looked at match."""
        indices = self._indices
        probes = _probes(indices) if self._source.depth_origin == "stereo" else []
        ordered = probes + [index for index in indices if index not in probes]
        for done, index in enumerate(ordered):
            told(done, len(ordered))
            if probes and done == len(probes):
                self._require_match(probes)
            frame = self._source.read_frame(index)
            self._places[index] = len(self._store)
            self._store.append(frame)

    def _require_match(self, probes: Sequence[int]) -> None:
        """Raises ClipError: none of these, nor of a few of the whole clip; a window may show none."""
        if any(self._store[self._places[index]].depth_mask.any() for index in probes):
            return
        others = [index for index in _probes(self._source.train_indices) if index not in self._places]
        if any(self._source.read_frame(index).depth_mask.any() for index in others):
            return
        labels = ", ".join(self._source.labels[index] for index in (*probes, *others))
        way = "--depth brightness, or Depth in the window, estimates it without a scale"
        wanted = "expected left and right images of one scene"
        raise ClipError(f"{wanted}, got none that match in {labels} ({way}): {self._source.path}")

    def in_place_of(self, clip: Clip) -> Clip:
        """The same frames opened otherwise, but for those that are here."""
        return replace(
            clip, read_frame=lambda index: (self._read if index in self._places else clip.read_frame)(index)
        )

    def hand_over(self) -> None:
        """From now on a frame that is read is no longer kept here."""
        self._handing = True

    def _read(self, index: int) -> Frame:
        index = numbered(index, len(self._source))
        if index not in self._places:
            return self._source.read_frame(index)
        if self._handing:
            return self._store.take(self._places.pop(index))
        return self._store[self._places[index]]


def _probes(indices: Sequence[int]) -> list[int]:
    last = len(indices) - 1
    return [indices[place] for place in (0, last // 2, last)] if last >= PROBED else []


def reading(clip: Clip) -> str:
    """What the reading of its frames is called."""
    return STAGES.get(clip.depth_origin, "reading frames") if clip.has_depth else "reading frames"
