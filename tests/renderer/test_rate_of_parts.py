"""How fast a part of a clip is: as the whole, but where its own frames come faster or slower."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.renderer.plane import plane_clip


def test_a_part_beside_a_pause_has_the_rate_of_its_own_frames() -> None:
    count = len(plane_clip())
    times = tuple(index / 25 + (10 if index >= count // 2 else 0) for index in range(count))
    clip = replace(plane_clip(), frames_per_second=(count - 1) / times[-1], frame_times=times)
    assert clip.between(0, count // 2 - 1).frames_per_second == pytest.approx(25)
    assert clip.every(1).frames_per_second == clip.frames_per_second
    assert not clip.is_steady
    assert clip.between(0, count // 2 - 1).is_steady


def test_times_that_are_rounded_change_no_rate() -> None:
    times = tuple(round(index / 30, 3) for index in range(len(plane_clip())))
    clip = replace(plane_clip(), frames_per_second=30.0, frame_times=times)
    assert {clip.between(first, first + 2).frames_per_second for first in range(len(clip) - 2)} == {30.0}
    assert clip.every(2).frames_per_second == 15.0
    assert clip.is_steady
    assert replace(clip, frames_per_second=None).between(0, 1).frames_per_second is None
