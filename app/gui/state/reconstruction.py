"""Reconstructions: the present one, those that wait, and those that lie on disk; how good and how long. A
part of the state."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from app.enhancement.settable import InputKind
from app.gui.session_file import KeptSettings
from app.gui.work.omissions import Looking, Omissions
from app.gui.work.run_measures import RunMeasures
from app.gui.work.runs import FoundRuns, LeftRequest, ModelRequest
from app.runs.job import TrainingJob
from app.runs.progress_log import EMPTY_LOG, TrainingLog
from app.runs.run_changes import Footprint
from app.runs.train_run import TrainRequest
from app.scenes.scene import Scene
from renderer.clip import Clip
from renderer.train.config import TrainConfig
from renderer.train.events import Finishing, Omission, Preparing, Progress, Started

QUALITIES = {"Draft": 500, "Standard": 3000, "Fine": 6000}
"""Iterations: enough to look at, the default, and twice that."""
OWN = "Custom"
JobStatus = Literal["none", "starting", "running", "paused", "finished", "failed", "cancelled", "elsewhere"]
"""elsewhere: when it was opened, another process trained it."""


@dataclass(frozen=True, eq=False)
class Waiting:
    """A reconstruction whose turn has not come yet, by value: what is chosen later does not change it."""

    clip: Clip | None
    """None: of an earlier session, still to be opened."""
    request: TrainRequest
    told: TrainingLog = EMPTY_LOG
    """Of a run that goes on: what it has said so far."""
    asleep: bool = False
    """Of an earlier session: not made until a person says so."""

    @property
    def clip_name(self) -> str:
        return self.request.clip_path.name if self.clip is None else self.clip.name


@dataclass
class Reconstruction:
    """What the user chose for the next job, and what the present one has said."""

    config: TrainConfig = field(default_factory=TrainConfig)
    input: InputKind = "original"
    kept: KeptSettings | None = None
    """What frames are enhanced with for the reconstruction; None: as the image is."""
    name: str = ""
    """Folder name of the next run; empty: made from the clip's name and the time."""

    status: JobStatus = "none"
    cancelling: bool = False
    """It was asked to end, and does so after the step in hand."""
    job: TrainingJob | None = None
    clip: Clip | None = None
    """The part that it is trained on."""
    request: TrainRequest | None = None
    """What the run was begun with."""
    preparing: Preparing | None = None
    """What is done before it starts."""
    planned: str = ""
    """What it will need of memory and disk."""
    started: Started | None = None
    started_at: float = 0.0
    """On the window's clock."""
    finishing: Finishing | None = None
    """What is done after its last step."""
    finishing_at: float = 0.0
    """When that began, on the window's clock."""
    progress: Progress | None = None
    told: TrainingLog = EMPTY_LOG
    """For the curves: also of the run's earlier processes."""
    warnings: list[str] = field(default_factory=list)
    ended: LeftRequest | None = None
    """Asks what it has left, once it has ended."""
    saved_nothing: bool = False
    """It failed before there was a run folder."""
    has_checkpoint: bool = False
    """It was cut short, and something of it can be looked at."""
    failure: str = ""
    way_out: str = ""
    """What can be done after a failure."""

    @property
    def run_path(self) -> Path | None:
        return self.request.run_path if self.request else None

    @property
    def iterations(self) -> int:
        """Of the run that is shown, else of the next one."""
        if self.progress is not None:
            return self.progress.iterations
        return self.request.config.iterations if self.request else self.config.iterations

    @property
    def iteration(self) -> int:
        """Done so far: at first as many as the checkpoint has that it resumes from."""
        if self.progress is not None:
            return self.progress.iteration
        if self.started is not None:
            return self.started.iteration
        return self.told.progress[-1].iteration if self.told.progress else 0

    @property
    def omitted(self) -> tuple[Omission, ...]:
        return self.started.omitted if self.started else ()

    @property
    def is_alive(self) -> bool:
        return self.status in ("starting", "running", "paused")

    def is_of(self, name: str) -> bool:
        """It goes on, and its run has this name."""
        return self.is_alive and self.run_path is not None and self.run_path.name == name

    @property
    def can_pause(self) -> bool:
        return self.status == "running" and not self.cancelling

    @property
    def can_resume(self) -> bool:
        return self.status == "paused" and not self.cancelling


@dataclass(frozen=True)
class Ending:
    """A job whose run has ended, and whose process is about to."""

    job: TrainingJob
    since: float
    """In the window's seconds."""


@dataclass
class RunQuestion:
    """What a person is asked about one run."""

    path: Path
    name: str | None = None
    """Its new one, as typed so far; None: whether it shall be deleted."""
    footprint: Footprint | None = None
    """Of its folder; None: not known yet."""

    @property
    def is_for_good(self) -> bool:
        """Deleted past the system's bin, which takes no such folder: never without saying so."""
        return self.footprint is not None and not self.footprint.has_bin


@dataclass
class Runs:
    """Job, queue and run actions change it; drawing reads it."""

    reconstruction: Reconstruction = field(default_factory=Reconstruction)
    queue: tuple[Waiting, ...] = ()
    """Reconstructions to be made after the present one, the next one first."""
    ending: Ending | None = None
    """Of the run that has ended last."""
    starts: bool = False
    """A person has asked for the next one: it starts with the next frame, where none is under way."""
    asked: bool = False
    """The panel that reconstructs is to come to the front."""
    wakings: int = 0
    """How often a person has said that some of an earlier session are to be made."""
    model_wish: ModelRequest | None = None
    """The newest model of the present run, or of the last one, until something else is shown."""
    preview: Scene | None = None
    """The model as it was last seen, of the newest run that was cut short."""
    is_listed: bool = False
    """The list of the clip's runs was drawn in the last frame."""
    found: FoundRuns | None = None
    """The newest such list."""
    trouble: str = ""
    question: RunQuestion | None = None
    """Before a run is renamed or deleted."""
    sees_measures: bool = False
    """Measures of the run that is shown were drawn in the last frame."""
    measures: RunMeasures | None = None
    """The newest of them."""
    asks_for_omissions: bool = False
    """The list of what the next reconstruction leaves out is unfolded."""
    omissions: Omissions | None = None
    """The newest such list."""
    looking: Looking | None = None
    """How far the next one is."""

    @property
    def next_waiting(self) -> Waiting | None:
        """The reconstruction that is to be made next: the first that is not asleep."""
        return next((waiting for waiting in self.queue if not waiting.asleep), None)

    def is_queued(self, path: Path) -> bool:
        """The run of that folder waits for its turn."""
        return any(waiting.request.run_path == path for waiting in self.queue)


def quality_of(iterations: int) -> str:
    """The word for a number of iterations; OWN for one without a word."""
    return next((name for name, steps in QUALITIES.items() if steps == iterations), OWN)


def _pace(run: Reconstruction, now: Progress) -> float:
    """Seconds a step, without the first ones, which may have compiled something, where others are known."""
    first = next((event for event in run.told.progress if event.iteration < now.iteration), None)
    if first is None or now.seconds <= first.seconds:
        return now.seconds / now.iteration
    return (now.seconds - first.seconds) / (now.iteration - first.iteration)


def expected_seconds(run: Reconstruction, iterations: int) -> float | None:
    """In all, of what is chosen, with so many iterations: steps at the pace of the run shown, and what that
    takes beside them, for each of its runs. None where it is of another method or has no pace yet."""
    begun, progress = run.request, run.progress
    if begun is None or progress is None or progress.iteration < 1:
        return None
    if (begun.config.method, begun.config.n_gaussians) != (run.config.method, run.config.n_gaussians):
        return None
    steps = _pace(run, progress) * iterations
    beside = 0.0 if progress.wall_seconds is None else max(progress.wall_seconds - progress.seconds, 0.0)
    return (steps + beside) * (2 if run.input == "both in turn" else 1)
