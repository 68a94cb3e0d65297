"""The file that describes a sweep: clips, task, and the settings to try."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import field
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Final

from annotated_types import Interval, Len
from pydantic import TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

from app.console.flags import problem
from app.errors import UserError
from app.files.image_files import is_image
from app.sweeps.design import STRICT, Sample
from app.sweeps.folder import is_in_sweep
from app.sweeps.names import BY_NAME
from app.sweeps.settings import Settings, TaskName, settings_of
from renderer.readers.image_files.file_kinds import VIDEOS
from renderer.regular_files import read_whole

MOST_JOBS: Final = 100_000
WILD: Final = frozenset("*?[")

Value = str | bool | int | float | list[str | int | float]
"""Of a setting, as TOML has it; several numbers are a list."""
Values = Annotated[list[Value], Len(1, 10_000)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Slurm:
    """What a job asks of Slurm."""

    partition: str | None = None
    account: str | None = None
    minutes: Annotated[int, Interval(ge=1, le=100_000)] = 120
    """After which Slurm ends a job."""
    memory_gb: Annotated[float, Interval(gt=0, le=4096)] = 4.0


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Spec:
    """A sweep. Every clip is combined with every variant, every point of the grid, every sampled point, and
    every seed."""

    clips: Annotated[list[str], Len(1, 10_000)]
    """Clips, images, videos and folders, or patterns such as data/*, which find nothing in folders of sweeps;
    relative to the file."""
    task: TaskName
    """enhance: enhance images and measure them; train: reconstruct, and evaluate on held-out frames; mesh:
    both, and the tissue surface as a file."""
    settings: Annotated[dict[str, Value], BY_NAME] = field(default_factory=dict)
    """Of all jobs, named as the flags of the command, here as everywhere with - or _ between words."""
    variants: Annotated[list[Annotated[dict[str, Value], BY_NAME]], Len(0, 1000)] = field(
        default_factory=list
    )
    """Settings that belong together, such as a method and its own ones."""
    grid: Annotated[dict[str, Values], BY_NAME] = field(default_factory=dict)
    """Settings and the values of each: every combination is tried."""
    sample: Sample | None = None
    """Points drawn from ranges of settings."""
    seeds: Annotated[list[Annotated[int, Interval(ge=0, le=2**31 - 1)]], Len(1, 10_000)] | None = None
    """Of training; empty: that of the settings."""
    frames: Annotated[int, Interval(ge=1, le=100_000)] = 8
    """Images of each clip that are enhanced and measured, evenly spread."""
    renders: bool = False
    """Render every held-out frame of each training, not the middle one alone."""
    models: bool = True
    """Keep the model of each training; checkpoints are kept of unfinished ones alone."""
    threads: Annotated[int, Interval(ge=1, le=1024)] = 1
    """CPU threads of each job."""
    slurm: Slurm = Slurm()

    def combinations(self) -> Iterator[dict[str, Value]]:
        """Settings of one clip's jobs, in the order of the file; seeds vary fastest."""
        names = list(self.grid)
        points = self.sample.points() if self.sample else [{}]
        seeds = [{"seed": seed} for seed in self.seeds] if self.seeds else [{}]
        for variant, values, point, seed in product(
            self.variants or [{}], product(*self.grid.values()), points, seeds
        ):
            yield self.settings | variant | dict(zip(names, values, strict=True)) | point | seed

    @property
    def varied(self) -> tuple[str, ...]:
        """Names of the settings in which jobs differ, without the seed."""
        names = [name for variant in self.variants for name in variant]
        names += [*self.grid, *(self.sample.ranges if self.sample else ())]
        return tuple(dict.fromkeys(name for name in names if name != "seed"))


def read_spec(path: Path) -> Spec:
    """Raises UserError: it cannot be read, is not TOML, or asks for what there is not."""
    try:
        return spec_of(tomllib.loads(read_whole(path).decode("utf-8-sig")), path)
    except UnicodeDecodeError as error:
        raise UserError(f"expected a sweep in TOML, as UTF-8 text: {path}") from error
    except ValueError as error:  # Of whole numbers of thousands of digits, too.
        raise UserError(f"expected a sweep in TOML ({error}): {path}") from error


def spec_of(given: Mapping[str, Any], path: Path) -> Spec:
    """`path`: what is named where something is wrong. Raises UserError."""
    try:
        spec = TypeAdapter(Spec).validate_python(dict(given))
        return _checked(spec)
    except ValidationError as error:
        raise UserError(f"{problem(error)}: {path}") from error
    except UserError as error:
        raise UserError(f"{error}: {path}") from error


def _checked(spec: Spec) -> Spec:
    """Names that are set in two places would silently win over each other."""
    sampled = list(spec.sample.ranges) if spec.sample else []
    once = [*spec.settings, *{name for variant in spec.variants for name in variant}, *spec.grid, *sampled]
    once += ["seed"] if spec.seeds else []
    twice = {name for name in once if once.count(name) > 1}
    if twice:
        raise UserError(f"expected each setting in one place, got {min(twice)} in two")
    if spec.task == "enhance" and spec.seeds:
        raise UserError('seeds: expected none with task = "enhance", which draws nothing at random')
    return spec


def all_settings(spec: Spec) -> tuple[Settings, ...]:
    """Of one clip's jobs, validated; without repeats. Raises UserError: a setting that the task refuses."""
    return tuple(dict.fromkeys(settings_of(spec.task, given) for given in spec.combinations()))


def clip_paths(spec: Spec, folder: Path) -> tuple[Path, ...]:
    """The clips, in the order of the file, those of a pattern sorted by name; none twice.

    Raises:
        UserError: nothing is there, or a text is no pattern.
    """
    paths: dict[Path, None] = {}
    for text in spec.clips:
        try:
            found = _matching(text, folder)
        except (ValueError, RuntimeError) as error:  # Of ** within a name; of ~ with a name of nobody.
            raise UserError(
                f"clips: expected a path or a pattern, got {text!r} ({error}): {folder}"
            ) from error
        if not found:
            raise UserError(f"clips: expected a clip, an image or a video, found nothing at {text}: {folder}")
        paths |= dict.fromkeys(found)
    return tuple(paths)


def _matching(text: str, folder: Path) -> list[Path]:
    """Of a pattern, what is there and can be a clip: folders and files of images and videos, but for what
    sweeps wrote, such as this one. Parts of `text` that are there as they are written are no pattern: folders
    may be called so."""
    parts = Path(text).expanduser().parts
    base = folder
    while parts and (not WILD & set(parts[0]) or (base / parts[0]).exists()):
        base, parts = base / parts[0], parts[1:]
    if not parts:
        return [base.absolute()] if base.exists() else []
    hits = base.glob(str(Path(*parts)))
    return sorted(hit.absolute() for hit in hits if _may_be_clip(hit) and not is_in_sweep(hit, base))


def _may_be_clip(path: Path) -> bool:
    is_one = path.is_dir() or is_image(path) or path.suffix.lower() in VIDEOS
    return is_one and not path.name.startswith(".")


def jobs_asked_for(spec: Spec, clips: int) -> int:
    """How many; checked before they are made. Raises UserError: more than MOST_JOBS."""
    count = clips * max(1, len(spec.variants)) * (len(spec.seeds) if spec.seeds else 1)
    for values in spec.grid.values():
        count *= len(values)
    count *= spec.sample.count if spec.sample else 1
    if count > MOST_JOBS:
        raise UserError(f"expected at most {MOST_JOBS} jobs, got {count}")
    return count
