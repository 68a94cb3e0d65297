"""Reconstructions off the window's thread: those of a clip that lie on disk, the model that one has now, and
what is left of one that has ended."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from app.errors import UserError
from app.files.provenance import digest, digested_files
from app.gui.work.opened_run import request_of
from app.runs.clip_selection import ClipPart
from app.runs.progress_log import EMPTY_LOG, TrainingLog, told
from app.runs.run_folder import RunFolder, RunRecord
from app.runs.run_lock import holder
from app.runs.train_run import TrainRequest
from app.scenes.scene import Scene, Training, run_scene
from renderer.clip import Clip
from renderer.gaussians import DynamicGaussians

Made = Literal["finished", "unfinished", "training"]


@dataclass(frozen=True)
class RunsRequest:
    """Which runs are wanted; `moment` grows when they are to be looked for again."""

    folder: Path
    clip: Clip
    moment: int


@dataclass(frozen=True, eq=False)
class ListedRun:
    """A run folder as the list shows it."""

    path: Path
    created: str
    """UTC, ISO 8601."""
    request: TrainRequest
    """What goes on with it, from where the clip lies now."""
    made: Made
    """"training": some process trains it at this moment."""
    has_checkpoint: bool
    iterations: int
    """That it takes in all, so far as it has said so; else that it was asked for."""
    psnr: float | None
    """dB: of held-out frames where that was measured, else the newest of the training frames."""
    told: TrainingLog
    """Of an unfinished run: what it has said so far."""

    @property
    def has_model(self) -> bool:
        """There is something of it to show."""
        return self.made == "finished" or self.has_checkpoint

    @property
    def iteration(self) -> int:
        """Steps that are known to be done."""
        if self.made == "finished":
            return self.iterations
        return self.told.progress[-1].iteration if self.told.progress else 0


@dataclass(frozen=True, eq=False)
class FoundRuns:
    """The answer: the newest run first."""

    request: RunsRequest
    runs: tuple[ListedRun, ...]
    unreadable: int
    """Run folders that cannot be read."""


@dataclass
class RunFinder:
    """Answers RunsRequests; reads again only what has changed."""

    _read: dict[tuple[Any, ...], tuple[RunRecord, ListedRun]] = field(default_factory=dict)
    _digests: dict[tuple[Any, ...], str] = field(default_factory=dict)
    """Of the clip that was looked at last, as its files were then."""

    def find(self, request: RunsRequest) -> Iterator[FoundRuns]:
        """Raises OSError: the folder of all runs cannot be listed."""
        inside = request.folder.iterdir() if request.folder.is_dir() else ()
        folders, runs, unreadable = sorted({path.resolve() for path in inside}), [], 0
        kept: dict[tuple[Any, ...], tuple[RunRecord, ListedRun]] = {}
        for run in (RunFolder(path) for path in folders):
            if not run.is_run:
                continue
            try:
                key = _key(run)
                kept[key] = record, listed = self._read.get(key) or _listed(run)
                if self._is_of(record, request.clip):
                    moved = replace(listed.request, clip_path=request.clip.path)
                    runs.append(replace(listed, request=moved, made=_made(run)))
            except (UserError, OSError):
                unreadable += 1
        self._read = kept
        runs.sort(key=lambda run: run.created, reverse=True)
        yield FoundRuns(request, tuple(runs), unreadable)

    def _is_of(self, record: RunRecord, clip: Clip) -> bool:
        """By its place, or where that differs by its bytes, which training compares before it goes on: of a
        clip of that name, or where nothing lies at the old place any more."""
        place = Path(record.clip.path)
        if place.resolve() == clip.path.resolve():
            return True
        trimmed = record.clip.part.trim is not None
        if not (trimmed or record.clip.frames == len(clip)):
            return False
        if record.clip.name != clip.name and place.exists():
            return False
        # A folder's own time tells nothing of its files: one may have been written over, or lie deeper.
        stats = [(file, file.stat()) for file in digested_files(clip.path)]
        key = clip.path, *((file, stat.st_size, stat.st_mtime_ns) for file, stat in stats)
        if key not in self._digests:
            self._digests = {key: digest(clip.path)}
        return record.clip.sha256 == self._digests[key]


def _key(run: RunFolder) -> tuple[Any, ...]:
    """Changes with what is read of the run."""
    stat = run.events_path.stat() if run.events_path.exists() else None
    said = (stat.st_size, stat.st_mtime_ns) if stat else None
    return run.path, run.record_path.stat().st_mtime_ns, run.is_finished, run.has_checkpoint, said


def _made(run: RunFolder) -> Made:
    if run.is_finished:
        return "finished"
    return "unfinished" if holder(run.path) is None else "training"


def _listed(run: RunFolder) -> tuple[RunRecord, ListedRun]:
    record, said = run.record(), told(run)
    newest = (said.evaluated or said.progress)[-1:]
    return record, ListedRun(
        path=run.path,
        created=record.created,
        request=request_of(run, record),
        made=_made(run),
        has_checkpoint=run.has_checkpoint,
        iterations=said.steps(record.config.iterations),
        psnr=newest[0].psnr if newest and math.isfinite(newest[0].psnr) else None,
        told=EMPTY_LOG if run.is_finished else said,
    )


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
    footage, part = _footage(folder, request)
    scene = run_scene(folder, request.model, footage, run.config, part, request.training)
    yield replace(scene, clip_path=run.clip_path)


def _footage(folder: RunFolder, request: ModelRequest) -> tuple[Clip | RunRecord, ClipPart]:
    """What the model is seen through: of a clip whose poses training estimated, the run's record."""
    with suppress(OSError, UserError):
        record = folder.record()
        if record.clip.poses is not None:
            return record, record.clip.part
    return request.clip, request.run.part


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
