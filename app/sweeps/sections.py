"""What a sweep says, in tables and diagrams: the same values for its page, the command and the window."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

from app.report.section import Cell, Column, Plate, Section, Table
from app.sweeps.plan import SweepRecord
from app.sweeps.summary import COUNTS, HIGHER, SHOWN, Spread, Summary, said
from app.sweeps.table import Row, column_of
from renderer.listing import count, listed

MOST_ROWS = 5000
"""Of all jobs, on the page; the files beside it have all."""


def sections(record: SweepRecord, table: Sequence[Row]) -> dict[str, Section]:
    """By the names of their links."""
    summary = Summary.of(table, record.varied)
    measures = [name for name in SHOWN[record.task] if name in summary.measures]
    failed = [row for row in table if row.state == "failed"]
    left = sum(row.state == "left" for row in table)
    counted = f"{len(summary.rows)} of {len(table)} jobs are finished, {len(failed)} failed, {left} are left."
    return {
        "settings": Section(
            title="Settings",
            sentences=(counted,),
            plates=tuple(
                Plate(title="Seconds of a job", diagrams=(summary.diagram(name),)) for name in measures
            ),
            tables=(over_all(summary, measures), *differences(summary, measures)),
        ),
        "best": Section(title="Best settings", tables=(best(summary, measures, summary.clips),)),
        "clips": Section(title="Clips", tables=(by_clip(summary, measures),)),
        "jobs": Section(title="Jobs", tables=(all_jobs(summary),)),
        **({"failed": Section(title="Failed jobs", tables=(failures(failed),))} if failed else {}),
    }


def over_all(summary: Summary, measures: Sequence[str]) -> Table:
    """A row a setting."""
    rows = []
    for setting in summary.settings:
        spreads = [summary.spread(setting, name) for name in measures]
        clips = max((one.count for one in spreads), default=0)
        rows.append((said(setting), clips, *_pairs(spreads)))
    return Table(
        title="Means over clips",
        columns=(Column("setting"), Column("clips"), *_columns(measures)),
        rows=tuple(rows),
        note="± is the standard deviation over clips of the means over seeds." + _left_out(summary, measures),
    )


def _left_out(summary: Summary, measures: Sequence[str]) -> str:
    """A sentence on clips over which no mean is taken; empty where there are none."""

    def left(name: str) -> tuple[str, ...]:
        compared = set(summary.compared_clips(name))
        return tuple(clip for clip in summary.measured_clips(name) if clip not in compared)

    told = _by_clips(measures, left, "without")
    clips = f" Means are over the clips of which every setting has the measure: {told}." if told else ""
    return clips + _seeds_left_out(summary, measures)


def _seeds_left_out(summary: Summary, measures: Sequence[str]) -> str:
    """The same on seeds of a clip."""
    told = _by_clips(measures, summary.uneven_clips, "of")
    return f" Means are over the seeds with which every setting has the measure: {told}." if told else ""


def _by_clips(measures: Sequence[str], clips_of: Callable[[str], tuple[str, ...]], word: str) -> str:
    """Measures and their clips, those of the same clips together; empty where none has any."""
    named: dict[tuple[str, ...], list[str]] = {}
    for name in measures:
        if clips := clips_of(name):
            named.setdefault(clips, []).append(name)
    return "; ".join(f"{listed(names)} {word} {listed(clips)}" for clips, names in named.items())


def by_clip(summary: Summary, measures: Sequence[str]) -> Table:
    """A row a clip and setting."""
    rows = []
    for clip in summary.clips:
        for setting in summary.settings:
            spreads = [summary.spread(setting, name, clip) for name in measures]
            seeds = max((one.count for one in spreads), default=0)
            if seeds:
                rows.append((clip, said(setting), seeds, *_pairs(spreads)))
    return Table(
        title="Means over seeds",
        columns=(Column("clip"), Column("setting"), Column("seeds"), *_columns(measures)),
        rows=tuple(rows),
        note="± is the standard deviation over seeds." + _seeds_left_out(summary, measures),
    )


def differences(summary: Summary, measures: Sequence[str]) -> Iterator[Table]:
    """Against the first setting; none where there is only one."""
    base, *others = summary.settings or ((),)
    if not others:
        return
    rows = []
    for setting in others:
        for name in measures:
            found = summary.difference(setting, base, name)
            if found.spread.count:
                low, high = (found.spread.mean + sign * found.half_width for sign in (-1, 1))
                clear = None if math.isnan(found.half_width) else "yes" if found.is_clear else "no"
                over = count(found.spread.count, found.over)
                rows.append((said(setting), name, over, found.spread.mean, low, high, clear))
    names = ("setting", "measure", "over", "difference", "difference from", "difference to", "differs from 0")
    yield Table(
        title=f"Differences from {said(base)}",
        columns=tuple(map(Column, names)),
        rows=tuple(rows),
        note="Of jobs of the same clip and seed; the interval of 95 % for the mean, by Student's t, is over "
        "clips, of their means over seeds. That over seeds is of one clip and says nothing of others.",
    )


def best(summary: Summary, measures: Sequence[str], clips: Sequence[str] = ()) -> Table:
    """By measure, over the compared clips and for each of these."""
    rows = []
    for name in measures:
        compared, measured = len(summary.compared_clips(name)), len(summary.measured_clips(name))
        together = "all clips" if compared == measured else f"{compared} of {measured} clips"
        for clip in (None, *clips):
            setting = summary.best(name, clip)
            if setting is not None:
                mean = summary.spread(setting, name, clip).mean
                rows.append((name, clip or together, said(setting), mean))
    columns = (Column("measure"), Column("clip"), Column("best setting"), Column("mean"))
    return Table(
        title="Best setting by measure",
        columns=columns,
        rows=tuple(rows),
        note=_left_out(summary, measures).strip(),
    )


def all_jobs(summary: Summary) -> Table:
    names = (*summary.varied, "seed")
    shown = [name for name in names if any(name in row.settings for row in summary.rows)]
    rows = [
        (
            row.clip,
            *(_cell(row.settings.get(name)) for name in shown),
            *(row.measures.get(name) for name in summary.measures),
            _cell(row.costs.get("seconds")),
        )
        for row in summary.rows[:MOST_ROWS]
    ]
    measures = [column_of(name, shown) for name in summary.measures]
    columns = (Column("clip"), *map(Column, shown), *map(Column, measures), Column("seconds"))
    cut = f"The first {MOST_ROWS}; " if len(summary.rows) > MOST_ROWS else ""
    return Table(
        title="Finished jobs", columns=columns, rows=tuple(rows), note=f"{cut}table.csv has every setting."
    )


def failures(failed: Sequence[Row]) -> Table:
    rows = tuple((row.clip, row.job, row.reason) for row in failed)
    return Table(title="Why", columns=(Column("clip"), Column("job"), Column("reason")), rows=rows)


def _columns(measures: Sequence[str]) -> Iterator[Column]:
    for name in measures:
        yield Column(name, best="" if name in COUNTS else "high" if name in HIGHER else "low")
        yield Column(f"{name} ±")


def _pairs(spreads: Sequence[Spread]) -> Iterator[Cell]:
    for one in spreads:
        yield one.mean
        yield one.deviation


def _cell(value: Cell) -> Cell:
    """A setting that is true or false as that word: a bool in a table reads as pass or FAIL."""
    return str(value).lower() if isinstance(value, bool) else value
