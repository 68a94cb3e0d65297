"""Windows of a long clip in the folder of a run that is being trained, each in one called by its frames."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np

from renderer.atomic_files import unlinked
from renderer.deformation.windowed_motion import LazyMotions, WindowedMotion
from renderer.gaussians import DynamicGaussians
from renderer.json_files import parsed
from renderer.raw_gaussians import joined
from renderer.stored_arrays import stored_metadata
from renderer.train.checkpoint import clear_checkpoints, read_newest_checkpoint
from renderer.train.events import Omission
from renderer.train.windows import Window

FOLDER: Final = "windows"
"""Of a run."""
_MODEL: Final = "model.safetensors"
_STATE: Final = "state"
_NAME: Final = re.compile(r"(\d{6})-(\d{6})")


@dataclass(frozen=True)
class FinishedWindow:
    """A window whose model is there."""

    fingerprint: str
    """Of clip and configuration, as of a checkpoint."""
    iterations: int
    seconds: float
    """Of its steps."""
    omitted: tuple[Omission, ...] = ()
    """What it does without; earlier versions do not say."""


@dataclass(frozen=True, eq=False)
class Unfinished:
    """What a training has left that was cut short."""

    model: DynamicGaussians
    iteration: int


def folder_of(run: Path, window: Window) -> Path:
    return run / FOLDER / f"{window.first:06d}-{window.last:06d}"


def is_finished(folder: Path) -> bool:
    return (folder / _MODEL).is_file()


def next_of(run: Path, windows: Sequence[Window]) -> Window:
    """The one that training begins or goes on with; the last where all are finished."""
    return next((window for window in windows if not is_finished(folder_of(run, window))), windows[-1])


def finish(folder: Path, model: DynamicGaussians, finished: FinishedWindow) -> None:
    """Its checkpoints go. Raises OSError: the model cannot be written."""
    model.save(unlinked(folder / _MODEL), {_STATE: json.dumps(asdict(finished))})
    clear_checkpoints(folder)


def clear(run: Path) -> None:
    """What earlier trainings in the folder have left, in windows or not."""
    shutil.rmtree(run / FOLDER, ignore_errors=True)
    clear_checkpoints(run)


def finished(folder: Path) -> FinishedWindow:
    """Raises ValueError: the file is damaged, or another."""
    path = folder / _MODEL
    try:
        told = parsed(stored_metadata(path)[_STATE])
        omitted = tuple(map(_omission, told.get("omitted", ())))
        return FinishedWindow(
            str(told["fingerprint"]), int(told["iterations"]), float(told["seconds"]), omitted
        )
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"expected a window of a run, got a damaged file or another: {path}") from error


def _omission(told: object) -> Omission:
    """Raises TypeError: it is none."""
    if not (isinstance(told, dict) and all(isinstance(value, str | None) for value in told.values())):
        raise TypeError(f"expected an omission in words, got {told}")
    return Omission(**told)


def load(folder: Path) -> DynamicGaussians:
    """Raises ValueError: the file is damaged, or another."""
    return DynamicGaussians.load(folder / _MODEL)


def in_windows(
    count: int, windows: Sequence[Window], models: Sequence[Callable[[], DynamicGaussians]]
) -> DynamicGaussians:
    """Models of windows of a clip of `count` frames as one, which gets each of them when it is needed."""
    raws = [model().raw for model in models]
    rows = np.cumsum([0, *map(len, raws)]).astype(np.int64)
    frames = np.array([[window.first, window.last] for window in windows], np.int64)
    motions = LazyMotions(len(models), lambda window: models[window]().motion)
    return DynamicGaussians(joined(raws), WindowedMotion(count, frames, rows, motions))


def unfinished(run: Path, count: int) -> Unfinished | None:
    """The newest of a clip of `count` frames, None where nothing is there.

    Raises ValueError: what is there is damaged.
    """
    if not (run / FOLDER).is_dir():
        return _at_checkpoint(run)
    windows, models, iteration = [], [], 0
    for folder in sorted((run / FOLDER).iterdir()):
        if (named := _NAME.fullmatch(folder.name)) is None:
            continue
        if is_finished(folder):
            iteration += finished(folder).iterations
            models.append(partial(load, folder))
        elif (newest := _at_checkpoint(folder)) is not None:
            iteration += newest.iteration
            models.append(partial(_the, newest.model))
        else:
            continue
        windows.append(Window(int(named[1]), int(named[2])))
    return Unfinished(in_windows(count, windows, models), iteration) if windows else None


def _at_checkpoint(folder: Path) -> Unfinished | None:
    checkpoint = read_newest_checkpoint(folder)
    if checkpoint is None:
        return None
    return Unfinished(DynamicGaussians.checked(checkpoint.arrays), checkpoint.iteration)


def _the(model: DynamicGaussians) -> DynamicGaussians:
    return model
