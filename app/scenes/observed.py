"""A scene without the Gaussians that no frame of its clip shows, for files that hold them all alike."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.errors import UserError
from app.scenes.scene import Scene


def observed(scene: Scene) -> Scene:
    """Drawn from elsewhere, it is as it was; from where the endoscope was, it lacks rims of what lies behind.

    Raises UserError: what its frames show is not known.
    """
    shown = scene.shown
    if shown is None:
        unfinished = "one that is not finished" if scene.is_of_run else "a splat file"
        wanted = "expected a finished run of one model, whose frames tell what they show"
        raise UserError(f"{wanted}, got {scene.split_by_time or unfinished}: {scene.name}")
    rows = np.flatnonzero(shown)
    whole, of = scene.of or (scene, np.arange(len(scene.model)))
    return replace(scene, model=scene.model.rows(rows), of=(whole, of[rows]))
