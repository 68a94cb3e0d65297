"""The table of a sweep: one row a job, with every setting and every measure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from app.files.atomic import replaced, write_bytes
from app.files.csv_table import csv_table
from app.files.provenance import strict_json
from app.report.section import Cell
from app.sweeps.jobs import JobFolder
from app.sweeps.plan import SweepRecord

HEAD: Final = ("job", "clip", "state", "reason")
"""The first columns."""
COSTS: Final = ("seconds", "peak_memory_mb", "threads", "machine", "version")
"""What a job took and where; the rest of a row is the same wherever it is done, but for times."""


@dataclass(frozen=True, eq=False)
class Row:
    """One job."""

    job: str
    clip: str
    clip_sha256: str
    state: str
    """finished, failed, or left to do."""
    reason: str
    """Why it failed."""
    settings: dict[str, Cell]
    measures: dict[str, float | None]
    costs: dict[str, Cell]

    def flat(self) -> dict[str, Cell]:
        """One value a column."""
        head: dict[str, Cell] = {name: getattr(self, name) for name in HEAD}
        measures = {column_of(name, self.settings): value for name, value in self.measures.items()}
        return head | self.settings | measures | self.costs


def column_of(measure: str, settings: Collection[str]) -> str:
    """What a measure is called beside settings: n_gaussians is asked for, and measured."""
    return f"measured_{measure}" if measure in settings else measure


def rows(record: SweepRecord, folder: Path) -> list[Row]:
    """In the order of the sweep; clips of one name are told apart by the first digits of their hashes."""
    found = [_row(key, JobFolder.of(folder, key)) for key in record.jobs]
    alike = Counter(name for name, digest in {(row.clip, row.clip_sha256) for row in found} if digest)
    return [
        replace(row, clip=f"{row.clip} ({row.clip_sha256[:6]})")
        if row.clip_sha256 and alike[row.clip] > 1
        else row
        for row in found
    ]


def _row(key: str, place: JobFolder) -> Row:
    facts = place.result()
    state = "finished" if facts else place.state
    told = facts or place.failed_facts() or {}
    settings = {name: _cell(value) for name, value in dict(told.get("settings") or {}).items()}
    return Row(
        job=key,
        clip=str(told.get("clip", "")),
        clip_sha256=str(told.get("clip_sha256", "")),
        state=state,
        reason=str(told.get("reason", "")),
        settings=settings,
        measures=dict(told.get("measures") or {}),
        costs={name: told.get(name) for name in COSTS} if facts else {},
    )


def _cell(value: Any) -> Cell:
    """Several values as one text, as the flags of `tune` take them."""
    if isinstance(value, list):
        return "/".join(map(str, value))
    return value if isinstance(value, str | float | int | bool) or value is None else strict_json(value)


def write_tables(table: Sequence[Row], folder: Path) -> tuple[Path, ...]:
    """CSV and JSON lines; Parquet where pyarrow is installed. All replace what was there."""
    flat = [row.flat() for row in table]
    columns = list(dict.fromkeys(name for row in flat for name in row))
    paths = [folder / "table.csv", folder / "table.jsonl"]
    write_bytes(paths[0], csv_table(columns, flat))
    write_bytes(paths[1], "".join(f"{strict_json(row)}\n" for row in flat).encode())
    if _write_parquet(flat, columns, folder / "table.parquet"):
        paths.append(folder / "table.parquet")
    return tuple(paths)


def _write_parquet(flat: Sequence[dict[str, Cell]], columns: Sequence[str], path: Path) -> bool:
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        return False
    arrays = {name: _uniform([row.get(name) for row in flat]) for name in columns}
    # A file that is open: pyarrow takes no path that is not UTF-8.
    with replaced(path) as temporary, temporary.open("wb") as file:
        parquet.write_table(pyarrow.table(arrays), file)
    return True


def _uniform(values: list[Cell]) -> list[Any]:
    """Of one type, as a column must be: numbers, truths, or texts."""
    known = [value for value in values if value is not None]
    if all(isinstance(value, bool) for value in known):
        return values
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in known):
        return [None if value is None else float(value) for value in values]
    return [None if value is None else str(value) for value in values]
