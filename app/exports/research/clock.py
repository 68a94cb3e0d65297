"""What frame numbers and times of an export count from, in words: the run, or a window alone."""

from __future__ import annotations

from app.scenes.scene import Scene


def frames_of(scene: Scene) -> str:
    """What frames are numbered within."""
    window = scene.record.window
    if window is None:
        return "of the run, counted from 0"
    return f"of window {window}, counted from 0 at frame {scene.start} of the whole clip"


def span_of(scene: Scene) -> str:
    """What times in [0, 1] go over."""
    return "the clip" if scene.record.window is None else f"window {scene.record.window}"
