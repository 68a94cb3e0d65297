"""The engine that `--on` names."""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path

from app.errors import UserError
from app.sweeps.engines.engine import Engine
from app.sweeps.spec import Slurm


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
    if on == "dask" or on.startswith(("tcp://", "tls://")):
        from app.sweeps.engines.dask import dask

        return dask(None if on == "dask" else on, workers, threads)
    if on == "slurm":
        from app.sweeps.engines.slurm import slurm as on_slurm

        return on_slurm(threads, slurm, folder)
    raise UserError(f"--on: expected local, dask, tcp://HOST:PORT or slurm, got {on!r}")
