"""What a sweep holds: apart from other files, since what runs a sweep takes a while to load."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from app.commands.described.fact import Fact, next_steps
from app.sweeps.plan import read_sweep
from app.sweeps.table import rows


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
