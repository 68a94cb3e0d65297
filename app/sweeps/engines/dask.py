"""Workers of dask.distributed: a cluster made here, or one that runs, under whatever started it."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

from app.errors import UserError
from app.sweeps.engines.engine import Engine, workers_for

SECONDS = 10
"""To find a scheduler."""
PER_WORKER = 4
"""Jobs handed over for each worker: enough that none waits for the client, and few are lost with it."""
LOSSES = 1000
"""Of workers, until dask gives a job up; before that, the sweep does."""


@contextmanager
def dask(address: str | None, workers: int | None, threads: int) -> Iterator[Engine]:
    """`address`: of a scheduler; None: a new cluster on this machine.

    Raises:
        UserError: distributed is not installed, or there is no scheduler at the address.
    """
    try:
        import dask
        from distributed import Client, LocalCluster
    except ImportError as error:
        raise UserError("--on dask: expected dask.distributed: pip install dask distributed") from error
    variables = {"NUMBA_NUM_THREADS": threads, "OMP_NUM_THREADS": threads}
    settings = {
        "distributed.scheduler.allowed-failures": LOSSES,
        "distributed.nanny.environ": variables,
        "distributed.nanny.pre-spawn-environ": variables,
    }
    with ExitStack() as stack:
        # What ends the sweep is told in one line.
        logging.disable(logging.CRITICAL)
        stack.callback(logging.disable, logging.NOTSET)
        stack.enter_context(dask.config.set(settings))
        place: Any = address
        if address is None:
            count = workers or workers_for(threads)
            cluster: Any = LocalCluster
            place = stack.enter_context(
                cluster(n_workers=count, threads_per_worker=1, dashboard_address=None)
            )
        try:
            connected: Any = Client
            client = stack.enter_context(connected(place, timeout=SECONDS))
        except (OSError, TimeoutError) as error:
            raise UserError(f"--on: expected a dask scheduler at {address}, found none") from error
        found = max(1, len(client.scheduler_info(n_workers=-1)["workers"]))
        with client.get_executor(pure=False) as executor:
            yield Engine(address or "dask", executor, found, PER_WORKER * found)
