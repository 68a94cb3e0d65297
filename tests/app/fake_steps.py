"""What takes the place of training in the tests of the job: functions that a spawned process can import."""

from __future__ import annotations

import errno
import os
import signal
import time
from collections.abc import Generator

import numpy as np

from app.errors import UserError
from app.runs.run_folder import RunFolder
from app.runs.train_run import TrainRequest
from renderer.deformation.motion import Still
from renderer.gaussians import DynamicGaussians
from renderer.raw_gaussians import RawGaussians
from renderer.train.events import Finished, Preparing, Progress, Snapshot, Started, TrainEvent

Steps = Generator[TrainEvent, None, None]


def model_of(count: int) -> DynamicGaussians:
    """A static model whose numbers tell how large it is."""
    raw = RawGaussians(
        means=np.full((count, 3), count, dtype=np.float32),
        quats=np.ones((count, 4), dtype=np.float32),
        log_scales=np.zeros((count, 3), dtype=np.float32),
        opacity_logits=np.arange(count, dtype=np.float32),
        colors=np.ones((count, 3), dtype=np.float32),
        harmonics=np.zeros((count, 0, 3), dtype=np.float32),
    )
    return DynamicGaussians(raw, Still())


def _progress(iteration: int) -> Progress:
    return Progress(iteration, 1_000_000, 0.5, 20.0, 1.0, 2.0, 3)


def endless(request: TrainRequest) -> Steps:
    """Goes on until it is told to stop; leaves a file behind when it is closed."""
    try:
        yield Started(0, 1_000_000, 3, ())
        for iteration in range(1, 1_000_000):
            time.sleep(0.01)
            yield _progress(iteration)
    finally:
        request.run_path.mkdir(exist_ok=True)
        (request.run_path / "closed").touch()


def growing(request: TrainRequest) -> Steps:
    """Snapshots of ever larger models, each followed by a Progress with its size; then the end."""
    yield Started(0, 4, 10, ())
    for count in (10, 11, 5000, 20):
        yield Snapshot(count, model_of(count))
        yield _progress(count)
    request.run_path.mkdir(exist_ok=True)
    RunFolder(request.run_path).save_model(model_of(7))
    yield Finished(4, 1.5, model_of(7))


def without_room(request: TrainRequest) -> Steps:
    """Snapshots for which shared memory has no room, but for the second; then the end."""

    def full(handle: int, offset: int, size: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    yield Started(0, 4, 10, ())
    real = os.posix_fallocate
    for count, reserve in ((10, full), (11, real), (5000, full), (6000, full)):
        os.posix_fallocate = reserve
        yield Snapshot(count, model_of(count))
        yield _progress(count)
    request.run_path.mkdir(exist_ok=True)
    RunFolder(request.run_path).save_model(model_of(7))
    yield Finished(4, 1.5, model_of(7))


def snapshot_then_endless(request: TrainRequest) -> Steps:
    yield Snapshot(1, model_of(10))
    yield from endless(request)


def mistaken(request: TrainRequest) -> Steps:
    yield Started(0, 1, 1, ())
    raise UserError("expected better, got this")


def broken(request: TrainRequest) -> Steps:
    yield Started(0, 1, 1, ())
    raise ZeroDivisionError("a bug")


def cut_off(request: TrainRequest) -> Steps:
    """Fails as reading does at a file's end, and as a pipe whose other end is gone."""
    yield _progress(1)
    raise EOFError("no more data")


def killed(request: TrainRequest) -> Steps:
    yield Snapshot(1, model_of(10))
    os.kill(os.getpid(), signal.SIGKILL)
    yield Started(0, 1, 1, ())


def killed_without_a_name(request: TrainRequest) -> Steps:
    """By a signal of real time, of Linux."""
    yield Started(0, 1, 1, ())
    os.kill(os.getpid(), 40)


def exited(request: TrainRequest) -> Steps:
    yield Started(0, 1, 1, ())
    os._exit(3)


def preparing(request: TrainRequest) -> Steps:
    """Tells what it prepares, and then goes on endlessly."""
    yield Preparing("matching left and right images", 3, 27, 2.0, 16.0)
    yield from endless(request)
