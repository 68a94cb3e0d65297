"""A file as if live: at its own rate, in a loop or once, late frames left out."""

from __future__ import annotations

import time
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.live.address import LiveAddress
from app.live.sources.opening import open_source
from app.live.sources.played import PlayedSource
from app.live.sources.source import Arrived, Wish
from assets import phantom_path
from renderer.clip import ClipError
from renderer.sources import open_clip

RATE = 100.0


def test_frames_come_at_their_times_one_after_another() -> None:
    source = PlayedSource(phantom_path(), Wish(frames_per_second=RATE, loop=False))
    taken = list[Arrived]()
    while (one := source.read()) is not None:
        assert time.perf_counter() >= one.at
        taken.append(one)
    count = len(open_clip(phantom_path()))
    assert len(taken) + sum(one.missed for one in taken) == count
    numbers = np.rint([RATE * one.seconds for one in taken])
    assert np.all(np.diff(numbers) >= 1)
    assert numbers[-1] == count - 1
    assert np.ptp([one.at - one.seconds for one in taken]) < 1e-6


def test_a_slow_reader_gets_the_newest_frame_and_is_told_how_many_it_missed() -> None:
    source = PlayedSource(phantom_path(), Wish(frames_per_second=RATE))
    first = source.read()
    time.sleep(0.2)
    second = source.read()
    assert first is not None
    assert second is not None
    assert second.missed == round(RATE * (second.seconds - first.seconds)) - 1 >= 15
    clip = open_clip(phantom_path())
    frame = round(RATE * second.seconds) % len(clip)
    assert np.array_equal(second.read(), clip.read_image(frame))


def test_it_begins_anew_at_its_end() -> None:
    source = PlayedSource(phantom_path(), Wish(frames_per_second=900.0))
    seconds = [one.seconds for _ in range(60) if (one := source.read()) is not None]
    assert len(seconds) == 60
    assert seconds == sorted(seconds)
    assert seconds[-1] > len(open_clip(phantom_path())) / 900


def test_images_of_several_sizes_are_refused(tmp_path: Path) -> None:
    for name, side in (("a1.png", 20), ("a2.png", 24)):
        cv2.imwrite(str(tmp_path / name), np.full((side, side, 3), 90, np.uint8))
    with pytest.raises(ClipError, match="20"):
        open_source(LiveAddress("file", str(tmp_path), "mixed"), Wish())
