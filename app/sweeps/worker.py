"""A worker's part of a sweep: it gets an order, finds the clip, does the job, and says what came of it.

All that crosses between processes and machines is here; it is plain values, and no engine is known.
"""

from __future__ import annotations

import multiprocessing
import os
import secrets
import tempfile
import threading
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final, Literal

from filelock import FileLock, Timeout

from app.errors import UserError, sentence
from app.files.atomic import write_bytes
from app.sweeps.jobs import PICTURE, Job, JobFolder, Keeps

TOKEN: Final = ".sweep"
"""A file with a random word in a sweep's folder, by which a worker knows it again."""


@dataclass(frozen=True)
class Order:
    """One job for one worker."""

    job: Job
    clip: Path
    """Where it lies for the one who asks."""
    sweep: Path
    token: str
    threads: int
    keeps: Keeps
    renders_again: bool = False
    """The job is finished, but for the renders of its held-out frames."""
    content: bytes | None = None
    """Of the clip, where the worker cannot see it; see `clip_transfer`."""

    @property
    def sent(self) -> int:
        """Bytes of the clip that go along."""
        return len(self.content or b"")


@dataclass(frozen=True)
class Outcome:
    """What came of an order."""

    state: Literal["finished", "failed", "needs the clip"]
    reason: str = ""
    details: str = ""
    facts: dict[str, Any] | None = None
    """Of the result: measures and what they cost; None where the worker wrote them itself."""
    picture: bytes | None = None
    """An image for the job's folder, where the worker cannot see that."""


def carry_out_order(order: Order) -> Outcome:
    """Do a job unless it is done; never raises but for what ends the process."""
    shared = JobFolder.of(order.sweep, order.job.key) if _sees(order) else None
    if shared and shared.state == "finished" and not order.renders_again:
        return Outcome("finished")
    if order.renders_again and not shared:
        return Outcome("failed", "the worker does not see the sweep's folder, where the model is")
    limit_threads(order.threads)
    from app.sweeps.clip_transfer import Missing, located
    from app.sweeps.tasks import render_again
    from enhance import ImageError
    from renderer.clip import ClipError

    try:
        if shared and order.renders_again:
            render_again(shared.path)
            shared.forget_failure()
            return Outcome("finished")
        clip = located(order.clip, order.job.clip_sha256, order.content)
        if shared:
            shared.path.mkdir(parents=True, exist_ok=True)
            shared.finish(order.job, _done(order, clip, shared.path))
            return Outcome("finished")
        with tempfile.TemporaryDirectory(prefix="vesselsplat-job-") as folder:
            facts = _done(order, clip, Path(folder))
            picture = Path(folder, PICTURE)
            seen = picture.read_bytes() if picture.exists() else None
            return Outcome("finished", facts=facts, picture=seen)
    except Missing:
        return Outcome("needs the clip")
    except (UserError, ClipError, ImageError) as error:
        return Outcome("failed", " ".join(str(error).split()))
    except MemoryError:
        return Outcome("failed", "out of memory")
    except OSError as error:
        return Outcome("failed", sentence(error), traceback.format_exc())
    except Exception as error:
        return Outcome("failed", f"{type(error).__name__}: {error}", traceback.format_exc())


def _done(order: Order, clip: Path, folder: Path) -> dict[str, Any]:
    from app.runs.memory import peak_memory_mb
    from app.sweeps.tasks import carry_out

    began = time.perf_counter()
    measures = carry_out(order.job, clip, folder, order.keeps)
    return {
        "measures": measures,
        "seconds": time.perf_counter() - began,
        "peak_memory_mb": peak_memory_mb(),
        "threads": order.threads,
        "machine": machine(),
    }


def _sees(order: Order) -> bool:
    """Whether the sweep's folder is on this machine, too, and the same."""
    try:
        return (order.sweep / TOKEN).read_text() == order.token
    except (OSError, UnicodeDecodeError):
        return False


def made_known(sweep: Path) -> str:
    """The word by which workers know the folder; written when it is not there yet."""
    place = sweep / TOKEN
    if not place.exists():
        write_bytes(place, secrets.token_hex(16).encode())
    return place.read_text()


@contextmanager
def sweep_locked(sweep: Path) -> Iterator[None]:
    """Nobody else hands out this sweep's jobs meanwhile. Raises UserError: another process does."""
    file = sweep / ".lock"
    lock = FileLock(file, blocking=False)
    try:
        lock.acquire()
    except Timeout as error:
        raise UserError(f"the sweep is being run by another process: {sweep}") from error
    try:
        yield
    finally:
        # Removed while it is held, so that nobody else's is; Windows lets go of it first.
        with suppress(PermissionError):
            file.unlink(missing_ok=True)
        lock.release()


def limit_threads(count: int) -> None:
    """Of numba and OpenCV in this process, as far as they were given that many at their start."""
    import cv2
    import numba

    most = numba.config.NUMBA_NUM_THREADS  # type: ignore[attr-defined]
    numba.set_num_threads(min(count, most))
    cv2.setNumThreads(count)


@cache
def machine() -> str:
    """Processor and number of cores."""
    from app.runs.processor import processor_name

    return f"{processor_name()}, {os.cpu_count()} cores"


def end_with_parent() -> None:
    """End this process when the one that started it is gone, which a pool's worker would not notice."""
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
