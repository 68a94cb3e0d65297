"""A job: one clip and one setting; its folder, which holds what came of it."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal

from app.files.atomic import write_bytes
from app.files.provenance import provenance, strict_json, version
from app.sweeps.folder import JOBS
from app.sweeps.settings import Settings, TaskName
from renderer.json_files import read_json

JobState = Literal["finished", "failed", "left"]
RESULT, FAILURE, PICTURE, RUN = "result.json", "failure.json", "picture.png", "run"
SURFACE: Final = "surface.glb"
RENDERS: Final = "renders"
"""In the folder of a job: what came of it, or why nothing did; an image; the run; its surface."""


@dataclass(frozen=True)
class Job:
    """What is done once, and never again."""

    task: TaskName
    clip: str
    """Its name."""
    clip_sha256: str
    settings: Settings
    frames: int
    """Of the clip that are enhanced."""

    @property
    def key(self) -> str:
        """Of the clip's content, every setting and the version: 16 hexadecimal digits."""
        facts = {
            "task": self.task,
            "clip": self.clip_sha256,
            "settings": self.settings.told(),
            "frames": self.frames if self.task == "enhance" else None,
            "version": version(),
        }
        return hashlib.sha256(strict_json(dict(sorted(facts.items()))).encode()).hexdigest()[:16]

    def told(self) -> dict[str, Any]:
        """The job as a row of the sweep's JSON."""
        return {"job": self.key, "task": self.task, "clip": self.clip, "clip_sha256": self.clip_sha256} | {
            "settings": self.settings.told()
        }


@dataclass(frozen=True)
class Keeps:
    """What stays of a training beside its measures, its middle render and its records."""

    model: bool = True
    renders: bool = False
    """Of all held-out frames, in the folder of the job where the worker sees it."""


@dataclass(frozen=True)
class JobFolder:
    """The folder of a job."""

    path: Path

    @classmethod
    def of(cls, sweep: Path, key: str) -> JobFolder:
        return cls(sweep / JOBS / key)

    @property
    def state(self) -> JobState:
        """By one look at its files; a damaged result is none."""
        if self.result() is not None:
            return "finished"
        return "failed" if (self.path / FAILURE).is_file() else "left"

    def result(self) -> dict[str, Any] | None:
        """None: there is none, or it is damaged, so that the job is done again."""
        return _read(self.path / RESULT)

    def failed_facts(self) -> dict[str, Any] | None:
        """Of a job that failed: its `reason` among them."""
        return _read(self.path / FAILURE)

    def finish(self, job: Job, facts: Mapping[str, Any]) -> None:
        """Write the result, the last of all files: what it is there with is whole."""
        write_bytes(self.path / RESULT, _text(provenance(**job.told(), **facts)))
        (self.path / FAILURE).unlink(missing_ok=True)

    def fail(self, job: Job, reason: str, details: str = "") -> None:
        facts = {"reason": reason} | ({"details": details} if details else {})
        write_bytes(self.path / FAILURE, _text(provenance(**job.told(), **facts)))

    def forget_failure(self) -> None:
        (self.path / FAILURE).unlink(missing_ok=True)


def _text(facts: Mapping[str, Any]) -> bytes:
    return strict_json(facts, indent=1).encode()


def _read(path: Path) -> dict[str, Any] | None:
    try:
        facts = read_json(path)
    except (OSError, ValueError):
        return None
    return facts if isinstance(facts, dict) else None
