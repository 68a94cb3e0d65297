"""What a sweep, its table, and the file that describes one hold; without loading what runs a sweep."""

from __future__ import annotations

import csv
from collections import Counter
from pathlib import Path
from typing import Any, Final

from app.commands.described.fact import Fact, next_steps
from app.errors import UserError
from app.sweeps.folder import is_sweep
from app.sweeps.plan import read_sweep
from app.sweeps.spec import clip_paths, jobs_asked_for, read_spec
from app.sweeps.table import HEAD, rows
from renderer.json_files import parsed
from renderer.listing import count

Stored = tuple[tuple[str, ...], list[dict[str, Any]]]
"""Names of the columns, and the rows."""


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


def _of_csv(path: Path) -> Stored:
    with path.open(encoding="utf-8", newline="") as file:
        table = csv.DictReader(file)
        return tuple(table.fieldnames or ()), list(table)


def _of_lines(path: Path) -> Stored:
    with path.open(encoding="utf-8") as lines:
        found = [parsed(line) for line in lines]
    return tuple(dict.fromkeys(name for row in found for name in dict(row))), found


def _of_parquet(path: Path) -> Stored:
    try:
        from pyarrow import parquet
    except ImportError as error:
        raise UserError(f"a table in Parquet needs pyarrow: pip install pyarrow ({path.name})") from error
    table = parquet.read_table(path)
    return tuple(table.column_names), table.to_pylist()


_TABLES: Final = {".csv": _of_csv, ".jsonl": _of_lines, ".parquet": _of_parquet}


def of_table(path: Path) -> tuple[Fact, ...]:
    """Raises UserError: it is no table of a sweep, or is one in Parquet without pyarrow."""
    try:
        columns, found = _TABLES[path.suffix.lower()](path)
    except (ValueError, TypeError, csv.Error) as error:
        raise UserError(f"expected the table of a sweep, got another file: {path}") from error
    states = Counter(row.get("state") for row in found) if columns[: len(HEAD)] == HEAD else None
    if states is None:
        raise UserError(f"expected the table of a sweep, with the columns {', '.join(HEAD)}: {path}")
    told = ", ".join(f"{number} {state}" for state, number in states.items())
    return (
        Fact("what", "table of a sweep", {"kind": "sweep table"}),
        Fact("jobs", f"{states.total()}: {told}" if told else "none", dict(states)),
        Fact("columns", count(len(columns), "column"), list(columns)),
        *([next_steps(path.parent, ("info", "PATH"))] if is_sweep(path.parent) else []),
    )
