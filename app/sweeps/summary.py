"""What a sweep's table says: means and spreads, paired differences, the best settings, and fronts."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from functools import cached_property
from statistics import NormalDist, fmean, median, stdev
from typing import Final, Literal

from app.enhancement.measures import METRICS, SMALLER_IS_BETTER
from app.report.diagrams import Diagram, Point
from app.report.section import Cell
from app.sweeps.settings import TaskName
from app.sweeps.table import Row

HIGHER: Final = (
    frozenset({"psnr", "psnr_masked", "psnr_tissue", "psnr_seldom", "ssim", "coverage"} | set(METRICS))
    - SMALLER_IS_BETTER
)
"""Measures of which more is better; of all others, less is, but for these."""
COUNTS: Final = frozenset({"images", "n_gaussians", "vertices", "triangles"})
"""Measures of which neither is better."""
SHOWN: Final[dict[TaskName, tuple[str, ...]]] = {
    "train": ("psnr", "psnr_seldom", "ssim", "depth_rmse_mm", "depth_rmse", "wall_seconds"),
    "mesh": ("surface_mm", "surface_95_mm", "surface", "surface_95", "vertices", "bytes", "export_seconds"),
    "enhance": ("vessel_contrast", "color_difference", "noise_gain", "milliseconds"),
}
"""By default, those that there are: lengths end with _mm of clips in millimetres."""
CERTAINTY: Final = 0.95
QUANTILES: Final = (
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
    2.201, 2.179, 2.160, 2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086,
)  # fmt: skip
"""Student's t at 97.5 %, for 1 to 20 degrees of freedom."""

Setting = tuple[tuple[str, Cell], ...]
"""The varied settings of a job."""


@dataclass(frozen=True)
class Spread:
    """Of a measure over several jobs."""

    count: int
    mean: float
    deviation: float
    """Standard deviation of a sample; NaN of one value."""

    @classmethod
    def of(cls, values: Sequence[float]) -> Spread:
        if not values:
            return cls(0, math.nan, math.nan)
        return cls(len(values), fmean(values), stdev(values) if len(values) > 1 else math.nan)


@dataclass(frozen=True)
class Difference:
    """Of a measure between two settings, over jobs of the same clip and seed."""

    spread: Spread
    """Over clips, of the means over seeds; over seeds, where there is one clip."""
    half_width: float
    """Of the interval of 95 % for the mean, by Student's t; NaN of one clip with one seed."""
    over: Literal["clip", "seed"] = "clip"

    @property
    def is_clear(self) -> bool:
        """Zero lies outside the interval."""
        return abs(self.spread.mean) > self.half_width

    @classmethod
    def of(cls, by_clip: Sequence[Sequence[float]]) -> Difference:
        """`by_clip`: of each clip, the differences of its seeds, one or more. Seeds of one clip are no
        further clips: they say how it varies on that clip alone."""
        if len(by_clip) == 1 and len(by_clip[0]) > 1:
            return cls(*_with_interval(by_clip[0]), "seed")
        return cls(*_with_interval([fmean(seeds) for seeds in by_clip]))


def _with_interval(values: Sequence[float]) -> tuple[Spread, float]:
    spread = Spread.of(values)
    if spread.count < 2:
        return spread, math.nan
    return spread, quantile(spread.count - 1) * spread.deviation / math.sqrt(spread.count)


def quantile(freedom: int) -> float:
    """Of Student's t at 97.5 %: from the table, beyond it by two terms of its expansion about the normal
    (Abramowitz & Stegun 26.7.5), within 0.001."""
    if freedom <= len(QUANTILES):
        return QUANTILES[freedom - 1]
    z = NormalDist().inv_cdf((1 + CERTAINTY) / 2)
    return z + (z**3 + z) / (4 * freedom) + (5 * z**5 + 16 * z**3 + 3 * z) / (96 * freedom**2)


@dataclass(frozen=True, eq=False)
class Summary:
    """Of the finished jobs of a table, by the settings in which they differ."""

    varied: tuple[str, ...]
    rows: tuple[Row, ...]

    @classmethod
    def of(cls, table: Iterable[Row], varied: Sequence[str]) -> Summary:
        return cls(tuple(varied), tuple(row for row in table if row.state == "finished"))

    @cached_property
    def settings(self) -> tuple[Setting, ...]:
        """In the order of the sweep."""
        return tuple(dict.fromkeys(map(self.setting, self.rows)))

    @cached_property
    def clips(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(row.clip for row in self.rows))

    @cached_property
    def measures(self) -> tuple[str, ...]:
        """Those that some job has."""
        named = (name for row in self.rows for name, value in row.measures.items() if value is not None)
        return tuple(dict.fromkeys(named))

    def setting(self, row: Row) -> Setting:
        return tuple((name, row.settings.get(name)) for name in self.varied if name in row.settings)

    def measured_clips(self, measure: str) -> tuple[str, ...]:
        """Those of which some setting has the measure."""
        measured = self._common.get(measure, {})
        return tuple(clip for clip in self.clips if clip in measured)

    def compared_clips(self, measure: str) -> tuple[str, ...]:
        """Those of which all settings have the measure, with a seed in common, but for settings that never
        have it: what fails on hard clips would otherwise look better than what does not."""
        return self._compared.get(measure, ())

    def uneven_clips(self, measure: str) -> tuple[str, ...]:
        """Those of which some setting has the measure with more seeds than the compared ones."""
        every = self._values.get(measure, {}).values()
        return tuple(
            clip
            for clip in self.measured_clips(measure)
            if any(by_clip.get(clip, {}).keys() - self._common[measure][clip] for by_clip in every)
        )

    def spread(self, setting: Setting, measure: str, clip: str | None = None) -> Spread:
        """Over seeds, of one clip: those with which every setting that has the measure of the clip has it, as
        hard seeds are like hard clips; over the compared clips of the means over seeds, of all."""
        if clip is not None:
            by_seed = self._values.get(measure, {}).get(setting, {}).get(clip, {})
            return Spread.of([by_seed[seed] for seed in by_seed if seed in self._common[measure][clip]])
        means = [self.spread(setting, measure, one) for one in self.compared_clips(measure)]
        return Spread.of([one.mean for one in means if one.count])

    def difference(self, setting: Setting, base: Setting, measure: str) -> Difference:
        """What `setting` has more than `base`."""
        ours, theirs = (self._values.get(measure, {}).get(one, {}) for one in (setting, base))
        pairs = [(ours[clip], theirs[clip]) for clip in ours if clip in theirs]
        by_clip = [[one[seed] - other[seed] for seed in one if seed in other] for one, other in pairs]
        return Difference.of([seeds for seeds in by_clip if seeds])

    def best(self, measure: str, clip: str | None = None) -> Setting | None:
        """Of one clip, or over the compared clips; None: nothing was measured there, or neither more nor less
        is better."""
        if measure in COUNTS:
            return None
        sign = -1 if measure in HIGHER else 1
        means = {setting: self.spread(setting, measure, clip).mean for setting in self.settings}
        known = {setting: mean for setting, mean in means.items() if not math.isnan(mean)}
        return min(known, key=lambda setting: sign * known[setting]) if known else None

    def diagram(self, measure: str) -> Diagram:
        """Every setting by its median seconds, since a worker's first job loads kernels, and mean measure;
        both over the compared clips and seeds."""
        points = []
        for setting in self.settings:
            times = [row.costs["seconds"] for row in self._compared_jobs(setting, measure)]
            seconds = median([float(one) for one in times if isinstance(one, int | float)] or [math.nan])
            mean = self.spread(setting, measure).mean
            if not math.isnan(seconds + mean):
                series = drawn_as(setting)
                points.append(Point(series=series, setting=said(setting), seconds=seconds, error=mean))
        words = measure.replace("_", " ")
        return Diagram(measure=words, points=tuple(points), more_is_better=measure in HIGHER)

    def _compared_jobs(self, setting: Setting, measure: str) -> Iterator[Row]:
        for clip in self.compared_clips(measure):
            for row in self._jobs.get((setting, clip), ()):
                if row.settings.get("seed") in self._common[measure][clip]:
                    yield row

    @cached_property
    def _jobs(self) -> Mapping[tuple[Setting, str], Sequence[Row]]:
        """By setting and clip: those of several seeds."""
        found: dict[tuple[Setting, str], list[Row]] = {}
        for row in self.rows:
            found.setdefault((self.setting(row), row.clip), []).append(row)
        return found

    @cached_property
    def _values(self) -> Mapping[str, Mapping[Setting, Mapping[str, Mapping[Cell, float]]]]:
        """By measure, setting, clip and seed."""
        found: dict[str, dict[Setting, dict[str, dict[Cell, float]]]] = {}
        for (setting, clip), jobs in self._jobs.items():
            for row in jobs:
                for measure, value in row.measures.items():
                    if value is not None:
                        by_clip = found.setdefault(measure, {}).setdefault(setting, {})
                        by_clip.setdefault(clip, {})[row.settings.get("seed")] = value
        return found

    @cached_property
    def _common(self) -> Mapping[str, Mapping[str, AbstractSet[Cell]]]:
        """By measure and clip: the seeds of all settings that have the measure of the clip."""
        found: dict[str, dict[str, AbstractSet[Cell]]] = {}
        for measure, by_setting in self._values.items():
            seeds = found[measure] = {}
            for by_clip in by_setting.values():
                for clip, by_seed in by_clip.items():
                    seeds[clip] = seeds.get(clip, by_seed.keys()) & by_seed.keys()
        return found

    @cached_property
    def _compared(self) -> Mapping[str, tuple[str, ...]]:
        """By measure."""
        found = {}
        for measure, by_setting in self._values.items():
            common = {clip for clip, seeds in self._common[measure].items() if seeds}
            common.intersection_update(*by_setting.values())
            found[measure] = tuple(clip for clip in self.clips if clip in common)
        return found


def drawn_as(setting: Setting) -> str:
    """The series of a diagram: the first varied setting whose values are words; numbers make one series."""
    words = ((name, value) for name, value in setting if isinstance(value, str) and "/" not in value)
    return next((f"{name} {value}" for name, value in words), "settings")


def said(setting: Setting) -> str:
    """In words."""
    return ", ".join(f"{name} {'auto' if value is None else value}" for name, value in setting) or "as set"
