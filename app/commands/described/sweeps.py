"""What a sweep, its table, and the file that describes one hold: what runs a sweep takes a while to load."""

from __future__ import annotations

import csv
from collections import Counter
from pathlib import Path

from app.commands.described.fact import Fact, next_steps
from app.errors import UserError
from app.sweeps.folder import is_sweep
from app.sweeps.plan import read_sweep
from app.sweeps.spec import clip_paths, jobs_asked_for, read_spec
from app.sweeps.table import HEAD, rows
from renderer.readers.listing import count


def of_sweep(folder: Path) -> tuple[Fact, ...]:
    """Raises UserError: it is damaged."""
    record = read_sweep(folder)
    states = Counter(row.state for row in rows(record, folder))
    jobs = ", ".join(f"{states[name]} {name}" for name in ("finished", "failed", "left") if states[name])
    return (
        Fact("what", f"sweep: {record.task}", {"kind": "sweep", "task": record.task}),
        Fact("jobs", f"{len(record.jobs)}: {jobs}", dict(states)),
        Fact("varied", ", ".join(record.varied) or "nothing", list(record.varied)),
        next_steps(folder, ("sweep", "PATH", "--table"), ("gui", "PATH")),
    )


def of_spec(path: Path) -> tuple[Fact, ...]:
    """Raises UserError: it describes no sweep, or clips that are not there."""
    spec = read_spec(path)
    clips = clip_paths(spec, path.parent)
    jobs = jobs_asked_for(spec, len(clips))
    return (
        Fact(
            "what", f"description of a sweep: {spec.task}", {"kind": "sweep description", "task": spec.task}
        ),
        Fact("clips", count(len(clips), "clip"), {"count": len(clips)}),
        Fact("jobs", count(jobs, "job"), {"count": jobs}),
        Fact("varied", ", ".join(spec.varied) or "nothing", list(spec.varied)),
        next_steps(path, ("sweep", "PATH", "--out", "OUT")),
    )


def of_table(path: Path) -> tuple[Fact, ...]:
    """Raises UserError: it is no table of a sweep."""
    try:
        with path.open(encoding="utf-8", newline="") as file:
            table = csv.DictReader(file)
            columns = tuple(table.fieldnames or ())
            states = Counter(row["state"] for row in table) if columns[: len(HEAD)] == HEAD else None
    except (UnicodeDecodeError, csv.Error) as error:
        raise UserError(f"expected the table of a sweep, got another file: {path}") from error
    if states is None:
        raise UserError(f"expected the table of a sweep, with the columns {', '.join(HEAD)}: {path}")
    told = ", ".join(f"{number} {state}" for state, number in states.items())
    return (
        Fact("what", "table of a sweep", {"kind": "sweep table"}),
        Fact("jobs", f"{states.total()}: {told}" if told else "none", dict(states)),
        Fact("columns", count(len(columns), "column"), list(columns)),
        *([next_steps(path.parent, ("info", "PATH"))] if is_sweep(path.parent) else []),
    )
