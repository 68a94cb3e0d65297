"""Where in a clip the playhead goes as time passes."""

from __future__ import annotations

from bisect import bisect_right

from app.scenes.view_selection import FRAMES_PER_SECOND
from renderer.clip import Clip

MOMENT = 1e-6
"""Seconds that a frame lasts at least, also beside another one of the same time."""


def onward(clip: Clip, span: tuple[int, int], playhead: float, seconds: float) -> float:
    """The playhead after so many seconds, in frames; each frame lasts as long as in the file, and after the
    last frame of the span comes its first."""
    first, last = span
    if not first <= playhead < last + 1:
        return float(first)
    frame = int(playhead)
    now = _time(clip, frame) + (playhead - frame) * _lasting(clip, frame) + seconds
    start = _time(clip, first)
    now = start + (now - start) % (_time(clip, last) + _lasting(clip, last) - start)
    frame = min(max(_frame_at(clip, now), first), last)
    return frame + min(max((now - _time(clip, frame)) / _lasting(clip, frame), 0.0), 1.0 - MOMENT)


def _rate(clip: Clip) -> float:
    return clip.frames_per_second or FRAMES_PER_SECOND


def _time(clip: Clip, frame: int) -> float:
    return clip.frame_times[frame] if clip.frame_times else frame / _rate(clip)


def _lasting(clip: Clip, frame: int) -> float:
    if not clip.frame_times or frame + 1 == len(clip):
        return 1 / _rate(clip)
    return max(clip.frame_times[frame + 1] - clip.frame_times[frame], MOMENT)


def _frame_at(clip: Clip, seconds: float) -> int:
    return bisect_right(clip.frame_times, seconds) - 1 if clip.frame_times else int(seconds * _rate(clip))
