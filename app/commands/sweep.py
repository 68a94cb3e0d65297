"""`vesselsplat sweep SPEC.toml --out DIR`: every clip with every setting, measured, in one table."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from rich.table import Table

from app.console.flags import refuse
from app.console.progress import WIDTH, Terminal, progress
from app.errors import UserError
from app.files.atomic import made, write_bytes
from app.files.legible import in_utf8
from app.files.provenance import provenance, strict_json
from app.report.section import Table as Measured
from app.report.section import said
from app.sweeps.engines.opening import open_engine, require_engine
from app.sweeps.jobs import JobFolder
from app.sweeps.keeping import not_kept, to_render
from app.sweeps.page import sweep_page
from app.sweeps.plan import Plan, estimate, planned, read_sweep, state, write_sweep
from app.sweeps.sections import best, differences, over_all
from app.sweeps.spec import read_spec
from app.sweeps.summary import SHOWN, Summary
from app.sweeps.sweep import run_jobs
from app.sweeps.table import Row, rows, write_tables
from app.sweeps.worker import sweep_locked
from renderer.listing import count

PAGE = "sweep.html"
NO_ENGINE: Final[Mapping[str, object]] = {"on": "local", "workers": None, "retry": False}
"""The flags of `add_engine_flags` where they are not given."""
PRINTED = 24
"""Rows of a table; the page has all."""
NAMED = 3
"""Failed jobs whose reasons are printed."""


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "sweep",
        metavar="SPEC.toml|DIR",
        type=Path,
        help="the sweep to run, or with --table the folder of one",
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder to write into")
    add_engine_flags(parser)
    parser.add_argument(
        "--dry-run", action="store_true", help="say how many jobs there are and how long they take"
    )
    parser.add_argument(
        "--table", action="store_true", help="means, differences and best settings of a sweep"
    )
    parser.add_argument(
        "--measures", nargs="+", metavar="NAME", help="with --table: other measures than the usual"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object on stdout")


def add_engine_flags(parser: argparse.ArgumentParser) -> None:
    """Where and how jobs run."""
    parser.add_argument(
        "--on",
        default="local",
        metavar="local|dask|tcp://HOST:PORT|slurm",
        help="where jobs run: processes on this machine, a new or a running dask cluster, or Slurm "
        "(default local)",
    )
    parser.add_argument(
        "--workers", type=_one_or_more, metavar="N", help="jobs at once (default: as the cores allow)"
    )
    parser.add_argument("--retry", action="store_true", help="repeat failed jobs")


def _one_or_more(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"expected 1 or more, got {text!r}")
    return int(text)


def run(flags: argparse.Namespace) -> None:
    if flags.table:
        refuse(flags, {"out": None, "dry_run": False, **NO_ENGINE}, "--table")
        _tell(flags.sweep, rows(read_sweep(flags.sweep), flags.sweep), flags.measures, flags.json)
        return
    if flags.measures:
        raise UserError("--measures: expected --table and the folder of a sweep, got a sweep to run")
    if flags.out is None:
        raise UserError("expected --out DIR, the folder to write into, or --table")
    if not flags.sweep.exists():
        raise UserError(f"expected a sweep in TOML, got no such file: {flags.sweep}")
    require_engine(flags.on)
    plan = planned(read_spec(flags.sweep), flags.sweep)
    if flags.dry_run:
        _preview(plan, flags)
        return
    table = carry_out(plan, flags.out, on=flags.on, workers=flags.workers, retry=flags.retry)
    _tell(flags.out, table, None, flags.json)
    require_all_done(plan, flags.out)


def carry_out(plan: Plan, folder: Path, *, on: str, workers: int | None, retry: bool) -> list[Row]:
    """Run what is left, then write the tables and the page; the rows of the tables. What finished jobs lack
    of what is asked for is a line on stderr.

    Raises:
        UserError: another process runs a sweep there, or the engine `on` is gone.
    """
    with made(folder), sweep_locked(folder):
        write_sweep(plan, folder)
        if retry:
            for job in plan.jobs:
                JobFolder.of(folder, job.key).forget_failure()
        try:
            _run(plan, folder, on, workers)
        except KeyboardInterrupt as interrupt:
            finished = state(plan.jobs, folder)["finished"]
            done = f"{finished} of {len(plan.jobs)} jobs are finished"
            raise KeyboardInterrupt(f"interrupted; {done}, the same command resumes") from interrupt
        finally:
            table = write_summary(folder)
        for sentence in not_kept(plan, folder):
            sys.stderr.write(f"{sentence}\n")
    return table


def require_all_done(plan: Plan, folder: Path) -> None:
    """Raises UserError: jobs failed; the first reasons are named, each once."""
    places = [(job, JobFolder.of(folder, job.key)) for job in plan.jobs]
    failed = [(job, place) for job, place in places if place.state == "failed"]
    reasons = Counter((job.clip, (place.failed_facts() or {}).get("reason")) for job, place in failed)
    if failed:
        told = "; ".join(
            f"{clip} ({number} jobs): {reason}" if number > 1 else f"{clip}: {reason}"
            for (clip, reason), number in [*reasons.items()][:NAMED]
        )
        more = f"; {len(reasons) - NAMED} other reasons in table.csv" if len(reasons) > NAMED else ""
        raise UserError(f"{len(failed)} of {len(plan.jobs)} jobs failed (--retry repeats them): {told}{more}")


def _run(plan: Plan, folder: Path, on: str, workers: int | None) -> None:
    if not state(plan.jobs, folder)["left"] and not to_render(plan, folder):
        return
    spec = plan.spec
    with (
        open_engine(on, workers=workers, threads=spec.threads, slurm=spec.slurm, folder=folder) as engine,
        progress(f"sweep, workers: {engine.workers}", len(plan.jobs)) as report,
    ):
        run_jobs(plan, folder, engine, report)


def write_summary(folder: Path) -> list[Row]:
    """The tables and the page of what is there so far."""
    record = read_sweep(folder)
    table = rows(record, folder)
    write_tables(table, folder)
    write_bytes(folder / PAGE, sweep_page(record, table, in_utf8(folder.absolute().name)).encode())
    return table


def _preview(plan: Plan, flags: argparse.Namespace) -> None:
    now = state(plan.jobs, flags.out)
    if flags.retry:
        now["left"] += now.pop("failed", 0)
    seconds, measured = estimate(plan.jobs, flags.out, retry=flags.retry)
    facts = {
        "clips": len(plan.clips),
        "jobs": len(plan.jobs),
        "finished": now["finished"],
        "failed": now["failed"],
        "left": now["left"],
        "worker_seconds_left": seconds,
        "measured_jobs": measured,
    }
    if flags.json:
        sys.stdout.write(strict_json(provenance(**facts)) + "\n")
        return
    took = (
        f"{_duration(seconds)} of one worker, by {measured} finished jobs"
        if seconds is not None
        else "unknown: no job has been measured yet"
    )
    jobs = f"{count(len(plan.jobs), 'job')} on {count(len(plan.clips), 'clip')}"
    states = f"{now['finished']} finished, {now['failed']} failed, {now['left']} left"
    sys.stdout.write(f"{jobs}: {states}\ntime left: {took}\n")


def _duration(seconds: float) -> str:
    hours, minutes = divmod(round(seconds / 60), 60)
    if hours:
        return f"{hours} h {minutes} min"
    return f"{minutes} min" if seconds >= 90 else f"{seconds:.0f} s"


def _tell(folder: Path, table: Sequence[Row], measures: Sequence[str] | None, as_json: bool) -> None:
    record = read_sweep(folder)
    summary = Summary.of(table, record.varied)
    chosen = _chosen(summary, measures or SHOWN[record.task], named=measures is not None)
    parts = [over_all(summary, chosen), *differences(summary, chosen), best(summary, chosen)]
    counts = {name: sum(row.state == name for row in table) for name in ("finished", "failed", "left")}
    if as_json:
        facts: dict[str, Any] = {"counts": counts, "tables": parts, "jobs": [row.flat() for row in table]}
        sys.stdout.write(strict_json(provenance(**facts)) + "\n")
        return
    for part in parts:
        if part.rows:
            print_table(part)
    told = ", ".join(f"{number} {name}" for name, number in counts.items() if number)
    sys.stdout.write(f"{folder}: {told or 'no jobs'}; table.csv, table.jsonl, {PAGE}\n")


def _chosen(summary: Summary, measures: Sequence[str], *, named: bool) -> list[str]:
    known = summary.measures
    for name in measures:
        if named and name not in known:
            raise UserError(f"--measures: expected names among {', '.join(known)}, got {name!r}")
    return [name for name in measures if name in known]


def print_table(part: Measured) -> None:
    """The first rows of a table on stdout."""
    table = Table(title=part.title, title_justify="left", title_style="", caption=part.note or None)
    for column in part.columns:
        table.add_column(column.name, overflow="fold")
    for row in part.rows[:PRINTED]:
        table.add_row(*(said(cell, column) for cell, column in zip(row, part.columns, strict=True)))
    # In a narrow terminal lines go on below: columns as narrow would cut their numbers in two.
    console = Terminal(width=max(Terminal().width, WIDTH))
    console.print(table)
    if len(part.rows) > PRINTED:
        console.print(f"{len(part.rows) - PRINTED} more rows in {PAGE}")
