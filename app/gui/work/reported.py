"""A report as its panel draws it: numbers ready for the plots."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.gui.work.reported_tables import ReportPart, part_of
from app.gui.work.swept import Swept, swept_jobs
from app.report.diagrams import (
    MILLISECONDS,
    Diagram,
    Gain,
    GainDiagram,
    Growth,
    Point,
    TimeUnit,
    gain_front,
    of_a_decade,
    pareto_front,
)
from app.report.section import Section, read_report
from app.sweeps.plan import read_sweep
from app.sweeps.sections import sections
from app.sweeps.summary import Summary
from app.sweeps.table import rows
from enhance import EnhanceParams
from enhance.accuracy import named
from renderer.listing import count

ENHANCEMENT = "enhancement"
CORNER = (0.3, 0.6)
"""Share of the axes that a legend takes in a corner."""
LEAST = 1e-6
"""What an error of 0 is drawn as, on a logarithmic axis."""


def plain(value: float, digits: int = 3) -> str:
    """With so many digits that count, and no power of ten: the window's font has no exponents."""
    return np.format_float_positional(value, digits, unique=False, fractional=False, trim="-")


@dataclass(frozen=True, eq=False)
class Line:
    """Points of one kind: what the axes say, across and up."""

    name: str
    across: NDArray[np.float64]
    up: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Scale:
    """What an axis spans, and where it has numbers; none: as the plot likes."""

    least: float
    most: float
    ticks: tuple[float, ...] = ()

    def share(self, value: float, *, logarithmic: bool) -> float:
        """How far along the axis a value is, 0 to 1."""
        if logarithmic:
            return math.log(value / self.least) / math.log(self.most / self.least)
        return (value - self.least) / (self.most - self.least)

    @property
    def labels(self) -> list[str]:
        """Of the ticks."""
        return [plain(tick) for tick in self.ticks]


@dataclass(frozen=True, eq=False)
class Chart:
    """One work-precision diagram, how a cost grows, or contrast against noise."""

    part: str
    title: str
    against: str
    """What the axis across is of."""
    measure: str
    logarithmic: bool
    """The axis up."""
    series: tuple[Line, ...]
    across: Scale
    up: Scale
    points: tuple[Point, ...] = ()
    front: Line | None = None
    fits: tuple[Line, ...] = ()
    """Drawn as lines: power laws or settings of a method, each called as its series; a front."""
    unit: TimeUnit = MILLISECONDS
    """Of run times."""

    @property
    def name(self) -> str:
        """To choose it by."""
        return f"{self.title}: {self.measure}" if self.points else self.title

    @cached_property
    def corner_is_free(self) -> bool:
        """Nothing lies in the corner beyond the front, where no setting is both faster and better."""
        for point in self.points:
            x, y = self.place(point)
            across = self.across.share(x, logarithmic=True)
            up = self.up.share(y, logarithmic=self.logarithmic)
            if across < CORNER[0] and (up if self.logarithmic else 1 - up) < CORNER[1]:
                return False
        return True

    def place(self, point: Point) -> tuple[float, float]:
        """On the axes."""
        up = max(point.error, LEAST) if self.logarithmic else point.error
        return self.unit.of_a_second * point.seconds, up

    def told(self, point: Point, digits: int = 3) -> str:
        """What was measured, in words."""
        time = plain(self.unit.of_a_second * point.seconds, digits)
        return f"{plain(point.error, digits)} in {time} {self.unit.name}"


@dataclass(frozen=True, eq=False)
class Reported:
    """All of them, and what the parts say in words and tables."""

    about: str
    charts: tuple[Chart, ...]
    parts: tuple[ReportPart, ...]
    sweep: Swept | None = None
    """Of a sweep, its jobs."""


def read_reported(path: Path) -> Reported:
    """Raises UserError when the file is no report."""
    report = read_report(path)
    machine: dict[str, Any] = report.machine
    about = f"{report.clip}, {report.utc[:10]}, {machine.get('processor')}, {machine.get('cores')} cores"
    parts = tuple(map(part_of, report.sections.values()))
    return Reported(about, tuple(charts_of(report.sections)), parts)


def read_sweep_report(folder: Path) -> Reported:
    """The tables and diagrams of a sweep's page, and its jobs. Raises UserError: it is none."""
    record = read_sweep(folder)
    table = rows(record, folder)
    summary, found = Summary.of(table, record.varied), sections(record, table)
    finished = f"{len(summary.rows)} of {count(len(table), 'job')} finished"
    about = f"{folder.name}: {finished}, {count(len(summary.clips), 'clip')}"
    parts = tuple(map(part_of, found.values()))
    swept = swept_jobs(record.task, summary, folder)
    return Reported(about, tuple(charts_of(found)), parts, swept)


def current(chart: Chart, params: object) -> Point | None:
    """The point of the setting that is chosen; None where it was not measured."""
    if chart.part != ENHANCEMENT or not isinstance(params, EnhanceParams):
        return None
    setting = named(params)
    return next((point for point in chart.points if (point.series, point.setting) == setting), None)


def charts_of(sections: Mapping[str, Section]) -> Iterator[Chart]:
    """All diagrams, in their order."""
    for part, section in sections.items():
        for plate in section.plates:
            for diagram in plate.diagrams:
                if diagram.points:
                    yield _chart(part, plate.title, diagram)
        yield from (_grown(part, growth) for growth in section.growths if growth.curves)
        yield from (_gained(part, diagram) for diagram in section.gain_diagrams)


def _chart(part: str, title: str, diagram: Diagram) -> Chart:
    logarithmic = not diagram.more_is_better
    names = dict.fromkeys(point.series for point in diagram.points)

    def line(name: str, points: list[Point]) -> Line:
        errors = np.array([point.error for point in points], np.float64)
        times = diagram.unit.of_a_second * np.array([point.seconds for point in points], np.float64)
        return Line(name, times, np.maximum(errors, LEAST) if logarithmic else errors)

    whole = line("", list(diagram.points))
    return Chart(
        part=part,
        title=title,
        against=diagram.unit.name,
        unit=diagram.unit,
        measure=diagram.measure,
        logarithmic=logarithmic,
        points=diagram.points,
        series=tuple(line(name, [one for one in diagram.points if one.series == name]) for name in names),
        front=line("Pareto front", list(pareto_front(diagram))),
        across=_scale(whole.across, logarithmic=True),
        up=_scale(whole.up, logarithmic=logarithmic),
    )


def _grown(part: str, growth: Growth) -> Chart:
    series = [
        Line(curve.label, np.array(curve.work, np.float64), np.array(curve.cost, np.float64))
        for curve in growth.curves
    ]
    return Chart(
        part=part,
        title=growth.title,
        against=growth.work,
        measure=growth.cost,
        logarithmic=True,
        series=tuple(series),
        fits=tuple(Line(curve.label, *curve.law()) for curve in growth.curves),
        across=_scale(np.concatenate([line.across for line in series]), logarithmic=True),
        up=_scale(np.concatenate([line.up for line in series]), logarithmic=True),
    )


def _gained(part: str, diagram: GainDiagram) -> Chart:
    def line(name: str, gains: Sequence[Gain]) -> Line:
        noise, contrast = (np.array([getattr(one, kind) for one in gains]) for kind in ("noise", "contrast"))
        return Line(name, noise, contrast)

    names = dict.fromkeys(gain.series for gain in diagram.gains)
    series = [line(name, [one for one in diagram.gains if one.series == name]) for name in names]
    whole = line("", diagram.gains)
    return Chart(
        part=part,
        title=diagram.title,
        against="noise gain",
        measure="vessel contrast gain",
        logarithmic=True,
        series=tuple(series),
        fits=(*series, line("Pareto front", gain_front(diagram))),
        across=_scale(whole.across, logarithmic=True),
        up=_scale(whole.up, logarithmic=True),
    )


def _scale(values: NDArray[np.float64], *, logarithmic: bool) -> Scale:
    """With a margin."""
    least, most = float(values.min()), float(values.max())
    if not logarithmic:
        margin = 0.08 * (most - least) or 1.0
        return Scale(least - margin, most + margin)
    margin = max((most / least) ** 0.08, 1.15)
    least, most = least / margin, most * margin
    decades = range(int(np.floor(np.log10(least))), int(np.ceil(np.log10(most))) + 1)
    ticks = (digit * 10.0**decade for decade in decades for digit in of_a_decade(least, most))
    return Scale(least, most, tuple(tick for tick in ticks if least <= tick <= most))
