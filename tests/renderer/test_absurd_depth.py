"""Depth that no tissue can have, in frames that come as arrays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from renderer.clip import Clip, Frame
from renderer.metrics import depth_rmse
from renderer.train.config import TrainConfig
from renderer.train.events import Evaluated, Finished
from renderer.train.frames import within_reach
from renderer.train.training import train
from tests.renderer.sheet import moving_sheet, same_bytes

CONFIG = TrainConfig(iterations=40, n_gaussians=500, node_columns=5)


def depth_of(frame: Frame) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    assert frame.depth is not None
    return frame.depth


def spoiled(clip: Clip, value: float, share: float = 0.02) -> Clip:
    """Here and there another depth."""
    frames = [clip.read_frame(index) for index in range(len(clip))]

    def read_frame(index: int) -> Frame:
        there = np.random.default_rng(index).random(depth_of(frames[index]).shape) < share
        depth = np.where(there, np.float32(value), depth_of(frames[index]))
        return replace(frames[index], depth=depth)

    return replace(clip, read_frame=read_frame)


def trained(clip: Clip) -> tuple[Finished, Evaluated]:
    events = list(train(clip, CONFIG))
    (*_, measured) = (event for event in events if isinstance(event, Evaluated))
    assert isinstance(events[-1], Finished)
    return events[-1], measured


def test_a_clip_with_absurd_depths_trains_as_one_without_depth_there() -> None:
    expected, _ = trained(spoiled(moving_sheet(), 0.0))
    for value in (np.inf, np.nan, 1e6, 1e10, 1e30):
        model, measured = trained(spoiled(moving_sheet(), value))
        assert same_bytes(model.model, expected.model), value
        assert measured.psnr > 20


def test_an_endless_depth_is_no_measurement() -> None:
    frame = spoiled(moving_sheet(), np.inf).read_frame(0)
    there = np.isfinite(depth_of(frame))
    assert np.array_equal(frame.depth_mask, frame.tissue_mask & there)
    drawn = np.full(there.shape, 52.0, np.float32)
    assert depth_rmse(drawn, depth_of(frame), frame.tissue_mask) == pytest.approx(
        depth_rmse(drawn, depth_of(frame), frame.depth_mask)
    )


def test_depths_that_tissue_may_have_stay_as_they_are() -> None:
    frame = moving_sheet().read_frame(0)
    deep = depth_of(frame).copy()
    deep[20, 20] *= 90
    frame = replace(frame, depth=deep)
    assert within_reach(frame) is frame
    without = replace(frame, depth=None)
    assert within_reach(without) is without
    nothing = replace(frame, depth=np.zeros_like(deep))
    assert within_reach(nothing) is nothing
