"""Frames that go to the disk come back equal, and training does not depend on where they lie."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from renderer.clip import Frame
from renderer.train import frame_store
from renderer.train.config import TrainConfig
from renderer.train.events import Finished
from renderer.train.frame_store import FrameStore
from renderer.train.frames import TrainFrame, halved, train_frame
from renderer.train.training import train
from tests.renderer.sheet import moving_sheet

ALL_ON_DISK = 0


def equal(first: Frame | TrainFrame, second: Frame | TrainFrame) -> bool:
    pairs = [(getattr(first, item.name), getattr(second, item.name)) for item in fields(first)]
    for one, other in pairs:
        if isinstance(one, np.ndarray):
            if one.dtype != other.dtype or one.shape != other.shape or one.tobytes() != other.tobytes():
                return False
        elif one != other:
            return False
    return True


def odd_frames() -> list[Frame]:
    """Sides that are no multiples of 8, no depth, NaN among the depths, an empty mask."""
    rng = np.random.default_rng(0)
    frames = [moving_sheet().read_frame(index) for index in range(4)]
    depth = rng.normal(size=frames[1].tissue_mask.shape).astype(np.float32)
    depth[0, :3] = np.nan, np.inf, -0.0
    tall = replace(
        frames[2],
        camera=replace(frames[2].camera, width=7, height=31),
        image=rng.integers(0, 255, (31, 7, 3), dtype=np.uint8),
        tissue_mask=rng.random((31, 7)) > 0.5,
        evaluation_mask=np.zeros((31, 7), bool),
        depth=None,
    )
    return [frames[0], replace(frames[1], depth=depth), tall, replace(frames[3], depth=None)]


@pytest.mark.parametrize("most", [ALL_ON_DISK, 20_000, 1 << 40])
def test_frames_come_back_equal_to_the_last_bit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, most: int
) -> None:
    monkeypatch.setattr(frame_store, "MOST_BYTES", most)
    frames = odd_frames()
    views = [train_frame(frame) for frame in frames]
    store, ready = FrameStore.of(frames, tmp_path), FrameStore.of(views, tmp_path)
    for _ in range(2):
        for index in (2, 0, 3, 1):
            assert equal(store[index], frames[index])
            assert equal(ready[index], views[index])
            assert equal(halved(ready[index]), halved(views[index]))
    assert [frame.index for frame in store[1:]] == [frame.index for frame in frames[1:]]


def test_frames_beyond_the_bound_are_not_in_memory_and_leave_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    frames = [moving_sheet().read_frame(index) for index in range(4)]
    sizes = [sum(getattr(frame, name).nbytes for name in ARRAYS) for frame in frames]
    monkeypatch.setattr(frame_store, "MOST_BYTES", sum(sizes[:2]))
    store = FrameStore.of(frames, tmp_path)
    assert [store[index] is frames[index] for index in range(4)] == [True, True, False, False]
    # Without a name from the first moment on, where the system has such files.
    assert list(tmp_path.iterdir()) == []
    for index in range(4):
        assert equal(store.take(index), frames[index])
    with pytest.raises(LookupError):
        store[0]


ARRAYS = ("image", "tissue_mask", "evaluation_mask", "depth")


@pytest.mark.parametrize("method", ["vesselsplat", "deform3dgs", "endogaussian"])
def test_training_is_the_same_from_memory_and_from_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, method: str
) -> None:
    config = TrainConfig(method=method, iterations=16, n_gaussians=200)  # type: ignore[arg-type]
    models = []
    for most in (1 << 40, ALL_ON_DISK):
        monkeypatch.setattr(frame_store, "MOST_BYTES", most)
        *_, last = train(moving_sheet(), config, folder=None)
        assert isinstance(last, Finished)
        models.append(last.model.arrays())
    assert models[0].keys() == models[1].keys()
    assert all(models[0][name].tobytes() == models[1][name].tobytes() for name in models[0])
