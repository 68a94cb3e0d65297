"""How fast the clip of a model goes: as the run records it, or, of earlier runs, as the clip itself says."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from app.runs.run_folder import RunFolder
from app.scenes.scene import Scene
from renderer.clip import ClipError
from renderer.sources import open_bare

FRAMES_PER_SECOND: Final = 15.0
"""Of camera paths, and of clips that do not tell."""


def clip_speed(scene: Scene) -> float | None:
    """Frames a second; None: neither the run nor the clip, where it still lies, tells."""
    if scene.frames_per_second is not None or scene.path is None or not scene.is_of_run:
        return scene.frames_per_second
    clip = RunFolder(scene.path).record().clip
    try:
        return open_bare(Path(clip.path), clip.options).frames_per_second
    except ClipError:
        return None
