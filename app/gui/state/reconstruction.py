"""The reconstruction that is made, or was last, and those that wait for their turn. A part of the state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, Protocol

from app.enhancement.settable import InputKind
from app.gui.work.run_models import LeftRequest
from app.runs.progress_log import EMPTY_LOG, TrainingLog
from app.runs.train_run import RECONSTRUCTION_PARAMS, TrainRequest
from renderer.clip import Clip
from renderer.gaussians import DynamicGaussians
from renderer.train.config import TrainConfig
from renderer.train.events import Omission, Preparing, Progress, Started

JobStatus = Literal["none", "starting", "running", "paused", "finished", "failed", "cancelled"]


class Job(Protocol):
    """A reconstruction in another process, as far as the window needs it."""

    def start(self) -> None: ...
    def poll(self) -> Sequence[object]: ...
    def latest_model(self) -> DynamicGaussians | None: ...
    def pause(self) -> None: ...
    def resume(self) -> None: ...
    def cancel(self) -> None: ...
    def close(self) -> None: ...


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
    d_factor: float = RECONSTRUCTION_PARAMS.k
    """Of the frames that are enhanced for the reconstruction."""
    name: str = ""
    """Folder name of the next run; empty: made from the clip's name and the time."""

    status: JobStatus = "none"
    job: Job | None = None
    clip: Clip | None = None
    """The part that it is trained on."""
    request: TrainRequest | None = None
    """What the run was begun with."""
    preparing: Preparing | None = None
    """What is done before it starts."""
    planned: str = ""
    """What it will need of memory and disk."""
    started: Started | None = None
    progress: Progress | None = None
    told: TrainingLog = EMPTY_LOG
    """For the curves: also of the run's earlier processes."""
    warnings: list[str] = field(default_factory=list)
    ended: LeftRequest | None = None
    """Asks what it has left, once it has ended."""
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
        return self.status == "running"

    @property
    def can_resume(self) -> bool:
        return self.status == "paused"
