"""One window of a model that is cut by time, as a scene of its own: for what needs the same Gaussians at all
moments."""

from __future__ import annotations

from dataclasses import replace

from app.errors import UserError
from app.scenes.scene import Scene
from renderer.model_windows import windows_of
from renderer.near_plane import middle_distance


def scene_of_window(scene: Scene, number: int) -> Scene:
    """The window of that number, counted from 1, with the frames that it was trained on.

    Raises:
        UserError: there is no such window, or it is empty.
    """
    windows = windows_of(scene.model)
    if len(windows) == 1:
        raise UserError(f"expected a model in windows, got one that is not cut: {scene.name}")
    if not 1 <= number <= len(windows):
        raise UserError(f"expected a window from 1 to {len(windows)}, got {number}: {scene.name}")
    window = windows[number - 1]
    frames = window.frames(len(scene.cameras))
    model, camera = window.model, scene.cameras[frames.start]
    if not len(model):
        raise UserError(
            f"expected Gaussians in window {number}, got none; maybe all were removed: {scene.name}"
        )
    return replace(
        scene,
        model=model,
        cameras=scene.cameras[frames.start : frames.stop],
        distance=middle_distance(model, camera),
        record=replace(scene.record, window=number),
        first=scene.start + frames.start,
        test_indices=tuple(index - frames.start for index in scene.test_indices if index in frames),
        saved_edits=None,
        of=None,
    )
