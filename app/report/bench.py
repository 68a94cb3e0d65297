"""What a report measures: in which parts, on which clip and machine, and the time they have."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final, cast

import psutil
from numba import get_num_threads

from app.report.runs import Runs
from app.report.section import Section
from app.runs.processor import load_average, processor_name
from app.runs.system_info import collect
from renderer.clip import Clip, ClipError
from renderer.listing import count
from renderer.phantom import Phantom, PhantomParams, write_phantom
from renderer.sources import open_clip
from renderer.train.trainer import require_depth

PHANTOM: Final = PhantomParams(n_frames=40)
Say = Callable[[str], None]


@dataclass(frozen=True)
class Clock:
    """The time of a part. What is measured never depends on it, only whether."""

    until: float
    """By time.monotonic."""

    @property
    def is_out(self) -> bool:
        """Nothing more is to be begun."""
        return time.monotonic() > self.until

    @classmethod
    def of(cls, seconds: float) -> Clock:
        return cls(time.monotonic() + seconds)


@dataclass(frozen=True, eq=False)
class Bench:
    """The clip, what is known about it, and the runs that parts share."""

    given: Path | None
    """The clip asked for; None is the phantom."""
    scenes: tuple[Path, ...]
    """Further clips, pictures and videos, for what they leave out and for Table 3."""
    work: Path
    """A folder for what is not kept."""
    say: Say

    @cached_property
    def clip_path(self) -> Path:
        """The phantom is written when it is asked for first."""
        if self.given is None:
            write_phantom(self.work / "phantom", PHANTOM)
        return self.given or self.work / "phantom"

    @cached_property
    def clip(self) -> Clip:
        """Raises ClipError when it cannot be read."""
        return open_clip(self.clip_path)

    @cached_property
    def why_untrained(self) -> str | None:
        """Why no run can be trained on the clip; None where one can."""
        try:
            require_depth(self.clip)
        except ClipError as error:
            # What follows is advice on flags that a report does not have, and the path.
            return str(error).split(" (")[0]
        return None

    @cached_property
    def truth(self) -> Phantom | None:
        """Of the phantom, whose depth and motion are known."""
        return Phantom(PHANTOM) if self.given is None else None

    @cached_property
    def scene_names(self) -> dict[Path, str]:
        """Of each of the scenes, all different."""
        return scene_names(self.scenes)

    @cached_property
    def runs(self) -> Runs:
        """Trained on the clip."""
        return Runs(self.clip_path, self.clip, self.work / "runs", self.say)


def measured_frames(clip: Clip) -> str:
    """Of which frames renders are: those held out of training, where the clip is long enough."""
    if clip.test_indices:
        return count(len(clip.test_indices), "held-out frame")
    return f"{count(len(clip.train_indices), 'training frame')} (the clip is too short for held-out ones)"


def scene_names(paths: Iterable[Path]) -> dict[Path, str]:
    """Of further scenes: the last two parts of each path, as a folder alone may be called "images"; more of
    them where another scene has the same."""
    whole = {path: path.resolve().parts for path in paths}
    return {path: _told_apart(parts, set(whole.values()) - {parts}) for path, parts in whole.items()}


def _told_apart(parts: tuple[str, ...], others: set[tuple[str, ...]]) -> str:
    length = 2
    while any(other[-length:] == parts[-length:] for other in others):
        length += 1
    return Path(*parts[-length:]).as_posix()


Measure = Callable[[Bench, Clock], Section]


@contextmanager
def opened(given: Path | None, scenes: tuple[Path, ...], say: Say) -> Iterator[Bench]:
    """What is trained in it is gone afterwards. Raises ClipError when the clip cannot be read."""
    with TemporaryDirectory(prefix="vesselsplat-report-") as name:
        bench = Bench(given, scenes, Path(name), say)
        if given is not None:
            bench.clip.read_image(0)
        yield bench


@dataclass(frozen=True)
class Part:
    """One section of the report, and its share of the time."""

    name: str
    share: float
    """Of the time, in relation to the others."""

    @property
    def measure(self) -> Measure:
        """Loads its module, and what that needs."""
        return cast(Measure, import_module(f"app.report.measures.{self.name}").measure)


PARTS: Final = (
    Part("enhancement", 1),
    Part("training", 200),
    Part("drawing", 2),
    Part("stability", 2),
    Part("left_out", 18),
    Part("visibility", 4),
    Part("paper", 25),
    Part("reading", 1),
    Part("growth", 3),
)


def machine() -> dict[str, Any]:
    """Without host and path: versions, processor, memory, driver, and the load as the measurements began."""
    known = collect()
    names = ("version", "python", "system", "cores", "packages", "opengl", "cuda_devices")
    return {name: known[name] for name in names} | {
        "processor": processor_name(),
        "memory_gb": round(psutil.virtual_memory().total / 1e9, 1),
        "threads": get_num_threads(),
        "load": load_average(),
    }
