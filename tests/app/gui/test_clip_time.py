"""Times of frames, as people read them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from app.gui.views.clip_time import clock, seconds_at
from renderer.clip import Clip


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0, "0:00.0"), (1.2, "0:01.2"), (59.96, "1:00.0"), (754.25, "12:34.2"), (3661.0, "1:01:01.0")],
)
def test_a_time_is_read_as_minutes_and_seconds(seconds: float, text: str) -> None:
    assert clock(seconds) == text


def test_a_frame_is_shown_when_the_file_says_or_else_by_its_rate(clip: Clip) -> None:
    assert seconds_at(clip, 5) == 0.5
    assert seconds_at(replace(clip, frame_times=(0, 0.1, 0.3, 0.4, 0.5, 0.7)), 5) == 0.7
    assert seconds_at(replace(clip, frames_per_second=None), 5) is None
