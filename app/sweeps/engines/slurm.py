"""Jobs of Slurm, through submitit."""

from __future__ import annotations

import shutil
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from app.errors import UserError
from app.sweeps.engines.engine import Engine
from app.sweeps.spec import Slurm

WINDOW = 500
"""Jobs in Slurm's queue at a time; clusters usually take 1000 or more of one person."""
EVERY = 1.0
"""Seconds between two looks at the queue."""


@contextmanager
def slurm(threads: int, wanted: Slurm, folder: Path) -> Iterator[Engine]:
    """Each job of the sweep is one of Slurm's.

    Raises:
        UserError: submitit is not installed, or this machine submits nothing to Slurm.
    """
    if shutil.which("srun") is None:
        raise UserError("--on slurm: expected a machine that submits jobs to Slurm, found no srun")
    with submitted_by("slurm", threads, wanted, folder) as executor:
        yield Engine("slurm", executor, WINDOW, WINDOW)


@contextmanager
def submitted_by(cluster: str, threads: int, wanted: Slurm, folder: Path) -> Iterator[Submitted]:
    """`cluster`: as of submitit, "slurm" or "local". What submitit writes lies in the sweep's folder, which
    the machines of a cluster share, and goes in the end."""
    try:
        import submitit
    except ImportError as error:
        raise UserError("--on slurm: expected submitit: pip install submitit") from error
    with TemporaryDirectory(prefix=".slurm-", dir=folder) as place:
        jobs = submitit.AutoExecutor(folder=place, cluster=cluster)
        jobs.update_parameters(
            name="vesselsplat",
            timeout_min=wanted.minutes,
            cpus_per_task=threads,
            mem_gb=wanted.memory_gb,
            slurm_setup=[f"export NUMBA_NUM_THREADS={threads}"],
            **({"slurm_partition": wanted.partition} if wanted.partition else {}),
            **({"slurm_account": wanted.account} if wanted.account else {}),
        )
        executor = Submitted(jobs)
        try:
            yield executor
        finally:
            executor.end()


class Submitted(Executor):
    """What submitit submits, as futures of `concurrent.futures`."""

    def __init__(self, jobs: Any) -> None:
        self._jobs = jobs
        self._running: dict[Future[Any], Any] = {}
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._watch = threading.Thread(target=self._look, daemon=True)
        self._watch.start()

    def submit(self, function: Callable[..., Any], /, *given: Any, **named: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_running_or_notify_cancel()
        job = self._jobs.submit(function, *given, **named)
        with self._lock:
            self._running[future] = job
        return future

    def _look(self) -> None:
        while not self._ended.wait(EVERY):
            with self._lock:
                done = {future: job for future, job in self._running.items() if job.done()}
                for future in done:
                    del self._running[future]
            for future, job in done.items():
                try:
                    future.set_result(job.result())
                except Exception as error:
                    future.set_exception(error)

    def end(self) -> None:
        """Cancel what runs."""
        self._ended.set()
        self._watch.join()
        for job in self._running.values():
            job.cancel()
