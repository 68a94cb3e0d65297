"""All jobs of a sweep, and which of them are done."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import Annotated, Final

from pydantic import AfterValidator, ConfigDict, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass as checked_dataclass

from app.console.progress import progress
from app.errors import UserError
from app.files.atomic import make_folder, write_bytes
from app.files.image_files import frames_in
from app.files.provenance import digest, provenance, strict_json
from app.sweeps.folder import SWEEP, is_sweep
from app.sweeps.jobs import Job, JobFolder, JobState
from app.sweeps.names import names_of
from app.sweeps.settings import Settings, TaskName, training_of
from app.sweeps.spec import Spec, all_settings, clip_paths, jobs_asked_for
from renderer.clip import ClipError
from renderer.layouts import layout_of
from renderer.readers.clip_options import ClipOptions
from renderer.readers.video_header import read_video_header
from renderer.regular_files import read_regular
from renderer.sources import open_bare, require_depth_source, with_chosen_depth

WITHOUT_DEPTH: Final = {
    "video": "a video, which has none",
    "image": "one image, which has none",
    "images": "a folder of images without any",
}
"""What is said of such a clip, by the name of its layout."""


@dataclass(frozen=True)
class Plan:
    """What is asked for."""

    spec: Spec
    jobs: tuple[Job, ...]
    clips: Mapping[str, Path]
    """Where they lie, by their digests."""

    def clip_of(self, job: Job) -> Path:
        return self.clips[job.clip_sha256]


@checked_dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="ignore"))
class SweepRecord:
    """What a sweep's folder says of it."""

    task: TaskName
    varied: Annotated[tuple[str, ...], AfterValidator(names_of)]
    jobs: tuple[str, ...]
    """Keys, in the order of the spec."""


RECORD: Final = TypeAdapter(SweepRecord)


def planned(spec: Spec, path: Path) -> Plan:
    """`path`: of the file with the spec. Raises UserError: a setting, a clip or their number."""
    paths = clip_paths(spec, path.absolute().parent)
    for clip in paths:
        _require_images(clip)
    try:
        jobs_asked_for(spec, len(paths))
        settings = all_settings(spec)
    except UserError as error:
        raise UserError(f"{error}: {path}") from error
    for clip in paths:
        _require_depth(clip, settings)
    clips: dict[str, Path] = {}
    names: dict[str, str] = {}
    with progress("reading clips", len(paths)) as report:
        for done, clip in enumerate(paths, 1):
            sha256 = digest(clip)
            clips.setdefault(sha256, clip)
            names[sha256] = clips[sha256].name
            report(done, clip.name)
    jobs = [
        Job(spec.task, names[sha256], sha256, setting, spec.frames)
        for sha256 in clips
        for setting in settings
    ]
    return Plan(spec, tuple({job.key: job for job in jobs}.values()), clips)


def _require_images(clip: Path) -> None:
    """Raises UserError: it is a folder without any, of which each job would only say so."""
    if clip.is_dir() and layout_of(clip).name == "images":
        frames_in(clip)


def _require_depth(clip: Path, settings: Sequence[Settings]) -> None:
    """Raises UserError: a video or images that cannot be opened or in which no setting finds depth, of which
    each job would only say so."""
    asked = {training.options for each in settings if (training := training_of(each)) is not None}
    try:
        lacks = asked and not any(_may_have_depth(clip, options) for options in asked)
    except ClipError as error:
        raise UserError(str(error)) from error
    if lacks:
        way = 'depth = "brightness" or "motion" in the settings of a sweep finds it without a scale'
        got = WITHOUT_DEPTH[layout_of(clip).name]
        raise UserError(f"expected clips with depth, got {got} ({way}): {clip}")


def _may_have_depth(clip: Path, options: ClipOptions) -> bool:
    """By the header of a video, and by the files of images. Raises ClipError: they cannot be opened."""
    layout = layout_of(clip).name
    if layout not in WITHOUT_DEPTH:
        return True
    if layout == "video":
        read_video_header(clip)
    bare = None if layout == "video" else open_bare(clip, options)
    try:
        require_depth_source(clip, options)
        found = bare and with_chosen_depth(bare, options)
    except ClipError:
        return False
    return found is None or found.has_depth or found.depth_origin == "motion"


def write_sweep(plan: Plan, folder: Path) -> None:
    """Write which jobs the sweep has, so that tables can be made of it. What other sweeps did in the same
    folder stays there."""
    make_folder(folder)
    keys = [job.key for job in plan.jobs]
    facts = provenance(task=plan.spec.task, varied=plan.spec.varied, jobs=keys, spec=plan.spec)
    write_bytes(folder / SWEEP, strict_json(facts).encode())


def read_sweep(folder: Path) -> SweepRecord:
    """Raises UserError: no folder of a sweep."""
    if not is_sweep(folder):
        raise UserError(f"expected the folder of a sweep, with {SWEEP}, found none in {folder}")
    try:
        return RECORD.validate_json(read_regular(folder / SWEEP))
    except ValidationError as error:
        raise UserError(f"expected the {SWEEP} of a sweep: {folder / SWEEP}") from error


def state(jobs: Sequence[Job], folder: Path) -> Counter[JobState]:
    """How many of them are finished, failed and left."""
    return Counter(JobFolder.of(folder, job.key).state for job in jobs)


def estimate(jobs: Sequence[Job], folder: Path, *, retry: bool = False) -> tuple[float | None, int]:
    """Seconds of one worker for the jobs that are left, with `retry` failed ones too, from those that are
    done, of the same method where there are any; None where none is done. And how many were measured."""
    known: dict[str, list[float]] = {}
    left: list[Job] = []
    for job in jobs:
        place = JobFolder.of(folder, job.key)
        result = place.result()
        if result is None:
            left += [] if place.state == "failed" and not retry else [job]
        elif isinstance(seconds := result.get("seconds"), int | float):
            known.setdefault(_kind(job), []).append(float(seconds))
    every = [seconds for group in known.values() for seconds in group]
    if not every:
        return None, 0
    return sum(fmean(known.get(_kind(job), every)) for job in left), len(every)


def _kind(job: Job) -> str:
    told = job.settings.told()
    return f"{told.get('method')} {told.get('iterations')}"
