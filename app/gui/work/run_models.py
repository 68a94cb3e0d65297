"""What a reconstruction has made: the model that it has now, and what is left of it on disk."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from app.runs.run_folder import RunFolder
from app.runs.train_run import TrainRequest
from app.scenes.scene import Scene, Training, run_scene
from renderer.clip import Clip
from renderer.gaussians import DynamicGaussians


@dataclass(frozen=True, eq=False)
class ModelRequest:
    """One model of a run that is made or has just been finished."""

    run: TrainRequest
    clip: Clip
    """The part that it is trained on."""
    model: DynamicGaussians
    training: Training


def run_model(request: ModelRequest) -> Iterator[Scene]:
    """Answers a ModelRequest; of a finished run the file of its model is read for its digest."""
    run = request.run
    folder = RunFolder(run.run_path)
    yield run_scene(folder, request.model, request.clip, run.config, run.part, request.training)


@dataclass(frozen=True, eq=False)
class LeftRequest:
    """One run that has ended."""

    path: Path


@dataclass(frozen=True)
class Left:
    """What it has left."""

    is_run: bool
    has_checkpoint: bool


def left_of(request: LeftRequest) -> Iterator[Left]:
    """Answers a LeftRequest."""
    folder = RunFolder(request.path)
    yield Left(folder.is_run, folder.has_checkpoint)
