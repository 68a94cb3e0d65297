"""Opens the clip of a reconstruction that waits since an earlier session, off the main thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from app.runs.progress_log import TrainingLog, told
from app.runs.run_folder import RunFolder
from app.runs.train_run import TrainRequest
from renderer.clip import Clip
from renderer.sources import open_clip


@dataclass(frozen=True)
class QueuedClipRequest:
    """Which one is to be made; `attempt` grows when a person tries again."""

    request: TrainRequest
    attempt: int


@dataclass(frozen=True, eq=False)
class QueuedClip:
    """What the window needs beside the request."""

    clip: Clip
    told: TrainingLog
    """Of a run that goes on: what it has said so far."""


def open_queued(request: QueuedClipRequest) -> Iterator[QueuedClip]:
    """Raises ClipError or UserError: the clip cannot be opened any more, or has no such part."""
    wanted = request.request
    clip = open_clip(wanted.clip_path, wanted.clip_options)
    wanted.part.of(clip)
    yield QueuedClip(clip, told(RunFolder(wanted.run_path)))
