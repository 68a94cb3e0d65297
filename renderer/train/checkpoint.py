"""Checkpoints: one safetensors file each, atomic (write, sync, rename), the last two kept. No pickle."""

from __future__ import annotations

import json
import math
import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from renderer.atomic_files import unlinked, written_atomically
from renderer.json_files import parsed
from renderer.stored_arrays import LazyArrays, read_arrays, write_arrays

KEPT = 2
_NAME = re.compile(r"checkpoint-(\d+)\.safetensors")


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """Everything that the next step depends on."""

    iteration: int
    """Steps done."""
    seconds: float
    """Training time so far."""
    fingerprint: str
    """Configuration and clip that the run was started with, as text."""
    arrays: dict[str, NDArray[Any]]


def write_checkpoint(folder: Path, checkpoint: Checkpoint) -> Path:
    """Write `checkpoint-NNNNNNN.safetensors`, one array after the other, and drop all but the last two."""
    state = {
        "iteration": checkpoint.iteration,
        "seconds": checkpoint.seconds,
        "fingerprint": checkpoint.fingerprint,
    }
    path = folder / f"checkpoint-{checkpoint.iteration:07d}.safetensors"
    with written_atomically(unlinked(path)) as partial:
        arrays = LazyArrays(list(checkpoint.arrays), checkpoint.arrays.__getitem__)
        write_arrays(partial, arrays, {"state": json.dumps(state)})
    for old in checkpoint_paths(folder)[:-KEPT]:
        # One that another program holds goes with the next.
        with suppress(PermissionError):
            old.unlink()
    return path


def checkpoint_paths(folder: Path) -> list[Path]:
    """Checkpoints in `folder`, oldest first; none where there is no such folder."""
    return sorted(path for path in folder.glob("*") if _NAME.fullmatch(path.name))


def clear_checkpoints(folder: Path) -> None:
    """Remove those in `folder`."""
    for path in checkpoint_paths(folder):
        path.unlink()


def read_newest_checkpoint(folder: Path) -> Checkpoint | None:
    """The newest readable checkpoint, or None. A damaged file is passed over for the one before it."""
    for path in reversed(checkpoint_paths(folder)):
        try:
            return read_checkpoint(path)
        except ValueError:
            continue
    return None


def read_checkpoint(path: Path) -> Checkpoint:
    """Raises ValueError when the file is damaged, or something else."""
    try:
        arrays, metadata = read_arrays(path)
        state = parsed(metadata["state"])
        iteration, seconds = int(state["iteration"]), float(state["seconds"])
        if iteration < 0 or not 0 <= seconds < math.inf:
            raise ValueError(f"iteration {iteration} after {seconds} s")
        return Checkpoint(iteration, seconds, str(state["fingerprint"]), arrays)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"expected a checkpoint, got a damaged file or another: {path}") from error
