"""The engine that `--on` names."""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path

from app.errors import UserError
from app.sweeps.engines.engine import Engine
from app.sweeps.spec import Slurm

ADDRESSES = ("tcp://", "tls://")
"""How those of dask's schedulers begin."""


def require_engine(on: str) -> None:
    """Before anything is written. Raises UserError: no such place."""
    if on not in ("local", "dask", "slurm") and not on.startswith(ADDRESSES):
        raise UserError(f"--on: expected local, dask, tcp://HOST:PORT or slurm, got {on!r}")


def open_engine(
    on: str, *, workers: int | None, threads: int, slurm: Slurm, folder: Path
) -> AbstractContextManager[Engine]:
    """Of `--on`: local, dask, tcp://HOST:PORT or slurm. `folder`: of the sweep.

    Raises:
        UserError: no such place, it is not reachable, or its package is not installed.
    """
    if on == "local":
        from app.sweeps.engines.local import local

        return local(workers, threads)
    if on == "dask" or on.startswith(ADDRESSES):
        from app.sweeps.engines.dask import dask

        return dask(None if on == "dask" else on, workers, threads)
    require_engine(on)
    from app.sweeps.engines.slurm import slurm as on_slurm

    return on_slurm(threads, slurm, folder)
