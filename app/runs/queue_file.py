"""Reconstructions that wait for their turn, on disk: they outlive the window. One file a process."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Final

from pydantic import TypeAdapter, ValidationError

from app.files.atomic import write_bytes
from app.files.process_files import claimed, own_file
from app.files.provenance import strict_json
from app.runs.train_run import TrainRequest
from renderer.json_files import read_json

KIND: Final = "queue"
SUFFIX: Final = ".json"
REQUEST = TypeAdapter(TrainRequest)
MOST_WAITING: Final = 1000
"""Of one process, that the next takes over."""


def queue_file(folder: Path) -> Path:
    """Where this process keeps what waits."""
    return own_file(folder, KIND, SUFFIX)


def keep_queue(path: Path, waiting: Sequence[TrainRequest]) -> None:
    """The file holds these, the next one first; without any there is none. Raises OSError or UserError."""
    if waiting:
        facts = [REQUEST.dump_python(request, mode="json") for request in waiting]
        write_bytes(path, strict_json(facts, indent=1).encode())
    else:
        path.unlink(missing_ok=True)


def take_over(folder: Path) -> tuple[tuple[TrainRequest, ...], str]:
    """What processes that have ended left waiting is this one's now, and no other's; and what of it could not
    be read, in a sentence, empty when all of it could. Raises OSError or UserError: it stays on disk.
    """
    files = claimed(folder, KIND, SUFFIX)
    told = [_read(path) for path in files]
    waiting = tuple(request for requests, _ in told for request in requests)
    if files:
        keep_queue(queue_file(folder), waiting)
    for path, (_, damaged) in zip(files, told, strict=True):
        if damaged:
            os.replace(path, path.with_name(f"{path.name}.broken"))
        else:
            path.unlink()
    kept = [f"{path.name}.broken" for path, (_, damaged) in zip(files, told, strict=True) if damaged]
    said = f"some queued reconstructions cannot be read; the file is kept as {', '.join(kept)}"
    return waiting, said if kept else ""


def _read(path: Path) -> tuple[list[TrainRequest], bool]:
    """What of the file can be read, and whether something cannot."""
    try:
        told = read_json(path)
    except (OSError, ValueError):
        return [], True
    if not isinstance(told, list):
        return [], True
    requests = []
    for one in told[:MOST_WAITING]:
        with suppress(ValidationError):
            requests.append(REQUEST.validate_python(one))
    return requests, len(requests) < len(told)
