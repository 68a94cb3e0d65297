"""A run folder as the window opens it: its clip where that lies now, and its model as trained so far."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from app.runs.progress_log import TrainingLog
from app.runs.run_folder import RunFolder, RunRecord
from app.runs.train_run import RECONSTRUCTION_PARAMS, TrainRequest
from app.scenes.scene import Scene, Training, finished_scene, run_scene
from renderer.clip import Clip
from renderer.sources import open_bare, with_chosen_depth
from renderer.train.window_files import unfinished


@dataclass(frozen=True, eq=False)
class OpenedRun:
    """A run folder with what can be shown of it."""

    path: Path
    record: RunRecord
    request: TrainRequest
    """What it was begun with."""
    model: Scene | None
    """Of a run that is not finished: its last checkpoint's, live; None where it left none."""
    told: TrainingLog
    is_trained: bool = False
    """Another process trains it at this moment."""

    @property
    def is_finished(self) -> bool:
        return self.model is not None and not self.model.live


def model_of(folder: RunFolder, record: RunRecord, clip: Clip | None, said: TrainingLog) -> Scene | None:
    """The model as trained so far, with the name that the clip has now; None: there is none yet."""
    finished = folder.is_finished
    model = finished_scene(folder, record) if finished else _last_checkpoint(folder, record, said)
    if model is not None and model.record.clip is not None:
        named = replace(model.record.clip, name=record.clip.name)
        place = None if clip is None else clip.path
        model = replace(model, record=replace(model.record, clip=named), clip_path=place)
    if model is not None and clip is not None and model.is_of(clip):
        # The same objects, so that comparing them is quick; it is done in every frame.
        cameras = clip.cameras[model.start : model.start + len(model.cameras)]
        speed = model.frames_per_second or clip.frames_per_second
        model = replace(model, cameras=cameras, frames_per_second=speed)
    return model


def _last_checkpoint(folder: RunFolder, record: RunRecord, said: TrainingLog) -> Scene | None:
    """The model as it was at the newest checkpoint that can be read; None where there is none."""
    try:
        left = unfinished(folder.path, record.clip.frames)
    except ValueError:
        return None
    if left is None:
        return None
    done = Training(left.iteration, said.steps(record.config.iterations), live=True)
    return run_scene(folder, left.model, record, record.config, record.clip.part, done)


def request_of(folder: RunFolder, record: RunRecord) -> TrainRequest:
    """The request that made the run, so that Continue asks for the same again."""
    params = record.enhancement.params if record.enhancement else RECONSTRUCTION_PARAMS
    return TrainRequest(
        clip_path=Path(record.clip.path),
        run_path=folder.path,
        config=record.config,
        clip_options=record.clip.options,
        part=record.clip.part,
        input=record.input,
        enhance_params=params,
    )


def place_of(record: RunRecord, beside: Path | None) -> Path:
    """Where the clip of a run lies: where it did, or beside, if nothing is there any more."""
    place = Path(record.clip.path)
    if place.exists() or beside is None or not beside.exists():
        return place
    return beside if record.clip.is_of(beside) else place


def clip_of(record: RunRecord, path: Path) -> tuple[Clip, Clip]:
    """As it was trained on, and with no depth but that of its own files. Raises ClipError."""
    bare = open_bare(path, record.clip.options)
    return record.clip.through_whole(with_chosen_depth(bare, record.clip.options)), bare
