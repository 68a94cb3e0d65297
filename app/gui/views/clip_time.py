"""When a frame of a video is shown, as people read time."""

from __future__ import annotations

from renderer.clip import Clip


def seconds_at(clip: Clip, index: int) -> float | None:
    """From the first frame; None where a clip does not say."""
    if clip.frame_times:
        return clip.frame_times[index]
    return index / clip.frames_per_second if clip.frames_per_second else None


def clock(seconds: float) -> str:
    """Minutes, seconds and tenths, "0:01.2"; with hours from the first on, "1:00:01.2"."""
    tenths = round(10 * seconds)
    hours, minutes = divmod(tenths // 600, 60)
    rest = f"{tenths % 600 / 10:04.1f}"
    return f"{hours}:{minutes:02d}:{rest}" if hours else f"{minutes}:{rest}"
