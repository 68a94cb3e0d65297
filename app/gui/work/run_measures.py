"""A finished run measured on frames that it was not trained on, off the window's thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from app.evaluation.mean import mean_of_finite
from app.runs.clip_selection import ClipPart
from app.runs.run_folder import RunFolder
from app.runs.trained_clip import enhanced_clip
from app.scenes.cpu_rendering import DrawOptions, draw_on_cpu
from app.scenes.scene import Scene
from renderer.clip import BoolImage, Clip
from renderer.depth.calibrated import with_calibration
from renderer.measuring.closeness import Closeness, closeness
from renderer.near_plane import near_plane
from renderer.readers.lenses.calibration import Calibration
from renderer.train.config import TrainConfig


@dataclass(frozen=True)
class RunMeasuresRequest:
    """One run as it was trained, and the clip that is open; `part` of it was trained on."""

    scene: Scene
    clip: Clip
    part: ClipPart
    config: TrainConfig
    lens: Calibration | None = None
    """That training found: the images of the open clip are undistorted by it first."""

    def as_trained(self) -> Clip:
        """The part of the clip as training saw it. Raises ClipError: it does not fit the lens."""
        clip = self.clip if self.lens is None else with_calibration(self.clip, self.lens)
        seen = self.part.of(clip)
        return seen.through(self.scene.cameras) if self.scene.poses_are_estimated else seen


@dataclass(frozen=True, eq=False)
class RunMeasures:
    """The answer, grown by a frame at a time."""

    request: RunMeasuresRequest
    count: int
    """Frames to measure; 0 where they cannot be."""
    frames: tuple[Closeness, ...] = ()

    @property
    def is_whole(self) -> bool:
        return len(self.frames) == self.count

    @property
    def are_held_out(self) -> bool:
        """Else the clip is too short to hold one out: they are those that the run was trained on."""
        return bool(self.request.scene.test_indices)

    def mean(self, name: str) -> float | None:
        """Of a field of Closeness; None: not measured."""
        return mean_of_finite(getattr(frame, name) for frame in self.frames)


def measure_run(request: RunMeasuresRequest) -> Iterator[RunMeasures]:
    """Measures as `evaluate` does. Raises ClipError: a frame cannot be read; UserError: run.json cannot."""
    scene, clip = request.scene, request.as_trained()
    indices = scene.test_indices or clip.train_indices
    nothing = RunMeasures(request, len(indices))
    seldom: BoolImage | None = None
    for mask in _seldom(clip, request.config):
        seldom = mask
        yield nothing
    enhancement, taken = scene.record.enhancement, list[Closeness]()
    trained = enhanced_clip(clip, enhancement) if enhancement else clip
    run = None if scene.path is None else RunFolder(scene.path)
    exposure = run.record().exposure if run and run.is_run else None
    trained = trained if exposure is None else exposure.through(trained)
    for index in indices:
        frame = trained.read_frame(index)
        near = near_plane(scene.model, frame.camera)
        drawn = draw_on_cpu(scene.model.at(frame.time), frame.camera, DrawOptions(near, scene.mode))
        taken.append(closeness(drawn.bytes, drawn.alpha, frame, seldom))
        yield RunMeasures(request, len(indices), tuple(taken))


def _seldom(clip: Clip, config: TrainConfig) -> Iterator[BoolImage | None]:
    """(H, W), True where few of the training frames so far show tissue; None where the camera moves."""
    # Training's modules take a while to import; the window must not wait for them.
    from renderer.measuring.tissue_seen import is_seldom, tissue_masks
    from renderer.train.trainer import split

    if not clip.camera_is_fixed:
        yield None
        return
    shown = np.zeros(clip.size[::-1])
    fit, _ = split(clip, config)
    for count, mask in enumerate(tissue_masks(clip, fit), 1):
        shown += mask
        yield is_seldom(shown / count)
