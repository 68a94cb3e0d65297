"""A sweep as its panel draws it: one point a job, and what can be taken from it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.enhancement.methods import EnhancementSettings
from app.enhancement.settable import Pixels, Scope
from app.enhancement.setting_words import LABELS
from app.errors import UserError
from app.files.image_files import read_image
from app.report.section import is_number
from app.runs.run_folder import RunFolder
from app.sweeps.jobs import PICTURE, RUN, JobFolder
from app.sweeps.settings import Enhancing, TaskName, settings_of
from app.sweeps.summary import SHOWN, Summary, drawn_as, said
from app.sweeps.table import Row, column_of
from renderer.clip import ByteImage

SECONDS: Final = "seconds"
WORDS: Final = {"dv": "DV", "bv": "BV", "dv_bv": "DV/BV", "ssim": "SSIM", "lpips": "LPIPS"}
"""Of measures whose names are abbreviations."""


def in_words(name: str) -> str:
    """A measure or a setting, as a person calls it; a setting whose slider has another name, with that name:
    its numbers are those of files and commands, and may not be the slider's."""
    said = WORDS.get(name, name.replace("_", " ").replace("color", "colour").replace("psnr", "PSNR"))
    label = LABELS.get(name)
    return said if label is None or label.lower() == said else f"{said} ({label})"


@dataclass(frozen=True, eq=False)
class SweptJob:
    """One finished job."""

    clip: str
    setting: str
    """In words."""
    series: str
    """What it is drawn with."""
    values: Mapping[str, float]
    """Measures, seconds, and varied settings that are numbers."""
    params: EnhancementSettings | None
    """To enhance by; None of trainings, and of methods without settings."""
    scope: Scope
    pixels: Pixels
    """Of their statistics."""
    folder: Path
    run: Path | None
    """Of a training."""


@dataclass(frozen=True, eq=False)
class Swept:
    """All finished jobs."""

    jobs: tuple[SweptJob, ...]
    first: tuple[str, str]
    """The axes to begin with."""

    @cached_property
    def columns(self) -> tuple[str, ...]:
        """What either axis can be of: whatever more than one job has."""
        names = (name for job in self.jobs for name in job.values)
        return tuple(dict.fromkeys(names))

    @cached_property
    def series(self) -> Mapping[str, tuple[SweptJob, ...]]:
        """Jobs by what they are drawn with."""
        names = dict.fromkeys(job.series for job in self.jobs)
        return {name: tuple(job for job in self.jobs if job.series == name) for name in names}

    def places(self, name: str, across: str, up: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Of a series, on the axes; NaN where a job has no such value."""
        jobs = self.series[name]
        first, second = ([job.values.get(axis, math.nan) for job in jobs] for axis in (across, up))
        return np.array(first, np.float64), np.array(second, np.float64)


@dataclass(frozen=True, eq=False)
class SweptImage:
    """The image that a job left."""

    job: SweptJob
    image: ByteImage


def swept_jobs(task: TaskName, summary: Summary, folder: Path) -> Swept:
    """`folder`: of the sweep."""
    measures = [name for name in SHOWN[task] if name in summary.measures]
    up = next(iter(measures), SECONDS)
    across = next((name for name in measures[1:] if name != up), SECONDS)
    order = tuple(dict.fromkeys((*measures, *summary.measures)))
    return Swept(tuple(_job(summary, row, folder, order) for row in summary.rows), (across, up))


def _job(summary: Summary, row: Row, folder: Path, order: Sequence[str]) -> SweptJob:
    """`order`: of the measures, those that tell most first."""
    setting, seed = summary.setting(row), row.settings.get("seed")
    named = tuple((in_words(name), value) for name, value in setting)
    words = said(named) if seed is None else f"{said(named)}, seed {seed}"
    chosen = {name: value for name, value in setting if is_number(value)}
    measures = {column_of(name, chosen): row.measures.get(name) for name in order}
    values = {**measures, SECONDS: row.costs.get(SECONDS), **chosen}
    place = JobFolder.of(folder, row.job)
    enhancing = _enhancing(place.result())
    run = place.path / RUN
    return SweptJob(
        clip=row.clip,
        setting=words,
        series=drawn_as(named),
        values={name: float(value) for name, value in values.items() if is_number(value)},
        params=enhancing.params if enhancing else None,
        scope=enhancing.statistics if enhancing else "automatic",
        pixels=enhancing.pixels if enhancing else "automatic",
        folder=place.path,
        run=run if RunFolder(run).is_finished else None,
    )


def _enhancing(facts: Mapping[str, Any] | None) -> Enhancing | None:
    if facts is None or facts.get("task") != "enhance":
        return None
    try:
        settings = settings_of("enhance", dict(facts["settings"]))
    except (UserError, KeyError, TypeError, ValueError):
        return None
    return settings if isinstance(settings, Enhancing) else None


def read_swept_image(job: SweptJob) -> Iterator[SweptImage]:
    """Raises UserError or OSError: there is none that can be read."""
    image = read_image(job.folder / PICTURE)
    if image.dtype != np.uint8:
        image = (image >> 8).astype(np.uint8)
    yield SweptImage(job, np.dstack([image] * 3) if image.ndim == 2 else np.ascontiguousarray(image[..., :3]))
