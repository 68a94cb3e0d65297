"""Runs that the parts of a report share: each is trained once, and measured as often as is asked."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

from app.errors import UserError
from app.files.provenance import strict_json
from app.report.outcomes import setting_of
from app.runs.run_folder import Input, RunFolder
from app.runs.train_run import Measured, TrainRequest, run_training
from app.runs.trained_clip import input_clip
from renderer.clip import Clip
from renderer.train.config import Method, TrainConfig
from renderer.train.events import Finished
from renderer.train.trainer import TrainingError
from renderer.train.training import train

WARMING = 6
"""Steps: both resolutions."""
STEPS: Final[dict[Method, tuple[int, ...]]] = {
    "vesselsplat": (1000, 125, 250, 500),
    "deform3dgs": (1000, 250),
    "endogaussian": (1000, 250),
    "static": (1000, 250),
}
"""Of the runs; the first, which the paper's tables are measured on, is the schedule of all other knobs."""
PUBLISHED: Final[dict[Method, int]] = {"deform3dgs": 3000, "endogaussian": 3000}
"""Steps of the published schedules; of endogaussian those with motion."""
SEEDS: Final = 3
"""Of the longest runs on the phantom, which are short enough for it."""
PIXELS, USUAL = 640 * 512, TrainConfig().n_gaussians


def schedule(clip: Clip, method: Method = "vesselsplat") -> TrainConfig:
    """Short, with as many Gaussians a pixel as by default at 640x512."""
    width, height = clip.size
    count = max(500, USUAL * width * height // PIXELS)
    return TrainConfig(method=method, iterations=STEPS[method][0], n_gaussians=count)


@dataclass(frozen=True, eq=False)
class Trained:
    """A finished run."""

    folder: RunFolder
    finished: Finished
    clip: Clip
    """With the frames that it was trained on, without what was left out of them."""


@dataclass(frozen=True, eq=False)
class Runs:
    """Of one clip."""

    clip_path: Path
    clip: Clip
    work: Path
    say: Callable[[str], None]
    _known: dict[str, Trained] = field(default_factory=dict)
    _warmed: set[Method] = field(default_factory=set)

    def trained(
        self, config: TrainConfig, kind: Input = "original", measured: Measured = "tissue"
    ) -> Trained:
        """Trains the first time; `measured`: of what the statistics of enhanced frames are.

        Raises:
            TrainingError: it fails, for lack of memory, too. Its folder, which is gone later, is not told.
        """
        key = hashlib.sha256(f"{kind} {measured} {strict_json(config)}".encode()).hexdigest()[:16]
        if key not in self._known:
            self._warm(config)
            self.say(f"training {setting_of(config)}, {kind} frames")
            folder = RunFolder(self.work / key)
            request = TrainRequest(
                clip_path=self.clip_path,
                run_path=folder.path,
                config=config,
                input=kind,
                measured=measured,
                device="cpu",
                resume=True,
            )
            try:
                finished = next(event for event in run_training(request) if isinstance(event, Finished))
            except UserError as error:
                raise TrainingError(str(error.__cause__ or error).removesuffix(f": {folder.path}")) from error
            record = folder.record()
            clip = input_clip(record.clip.as_trained(self.clip), record)
            self._known[key] = Trained(folder, finished, clip)
        return self._known[key]

    def seconds_again(self, config: TrainConfig, kind: Input) -> float:
        """Of the training steps of a run that was trained before."""
        self.say(f"timing {setting_of(config)}, {kind} frames")
        events = train(self.trained(config, kind).clip, config)
        return next(event.seconds for event in events if isinstance(event, Finished))

    def _warm(self, config: TrainConfig) -> None:
        """Compile what a method needs, so that no run's time contains it."""
        if config.method not in self._warmed:
            self._warmed.add(config.method)
            for _ in train(self.clip, replace(config, iterations=WARMING)):
                pass
