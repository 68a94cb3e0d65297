"""Clips whose numbers cannot be calculated with: refused in one line, never a model of nothing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from renderer.clip import Clip, ClipError
from renderer.phantom import PhantomParams, write_phantom
from renderer.readers.data_sets.endonerf_poses import POSES
from renderer.sources import open_clip
from renderer.train import trainer
from renderer.train.config import TrainConfig
from renderer.train.events import Finished
from renderer.train.trainer import TrainingError
from renderer.train.training import train
from tests.renderer.sheet import moving_sheet

CONFIG = TrainConfig(iterations=10, n_gaussians=100)


def scaled(clip: Clip, factor: float) -> Clip:
    """Depth times `factor`."""

    def read_frame(index: int):  # type: ignore[no-untyped-def]
        frame = clip.read_frame(index)
        assert frame.depth is not None
        return replace(frame, depth=(frame.depth * np.float32(factor)).astype(np.float32))

    return replace(clip, read_frame=read_frame)


def moved(clip: Clip, distance: float) -> Clip:
    """The cameras far from the origin, all by the same."""
    pose = np.eye(4)
    pose[:3, 3] = distance
    cameras = tuple(camera.moved(pose @ camera.camera_from_world) for camera in clip.cameras)

    def read_frame(index: int):  # type: ignore[no-untyped-def]
        frame = clip.read_frame(index)
        return replace(frame, camera=cameras[frame.index])

    return replace(clip, cameras=cameras, read_frame=read_frame)


@pytest.mark.parametrize("factor", [1e-30, 1e-12, 1e12, 1e30])
def test_depth_that_is_no_length_is_refused(factor: float) -> None:
    with pytest.raises(ClipError, match="expected tissue at a depth of"):
        list(train(scaled(moving_sheet(), factor), CONFIG))


@pytest.mark.parametrize("distance", [1e9, 1e14])
def test_cameras_where_float32_tells_no_pixels_apart_are_refused(distance: float) -> None:
    with pytest.raises(ClipError, match="where float32 resolves pixels"):
        list(train(moved(moving_sheet(), distance), CONFIG))


@pytest.mark.parametrize(("factor", "distance"), [(1e-6, 0.0), (1e6, 0.0), (1.0, 1e4)])
def test_within_the_bounds_a_model_comes_of_it(factor: float, distance: float) -> None:
    *_, last = train(moved(scaled(moving_sheet(), factor), distance), CONFIG)
    assert isinstance(last, Finished)
    assert len(last.model) > 50
    assert all(np.isfinite(value).all() for value in last.model.arrays().values())


def test_a_model_that_no_frame_shows_is_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    """It used to be written, of 0 Gaussians, "nan%" of them at rest."""

    def none_seen(gaussians, *_: object):  # type: ignore[no-untyped-def]
        return gaussians.rows(np.zeros(0, np.int64)), ()

    monkeypatch.setattr(trainer, "without_unseen", none_seen)
    with pytest.raises(TrainingError, match="no training frame shows any Gaussian"):
        list(train(moving_sheet(), CONFIG))


@pytest.mark.parametrize("focal", [1e-30, -5.0, 0.0, 1e300, np.nan])
def test_a_focal_length_that_is_none_names_the_clip(tmp_path: Path, focal: float) -> None:
    clip = tmp_path / "clip"
    write_phantom(clip, PhantomParams(n_frames=3, width=64, height=48))
    poses = np.load(clip / POSES)
    poses[:, 14] = focal
    np.save(clip / POSES, poses)
    with pytest.raises(ClipError) as told:
        open_clip(clip)
    assert str(clip) in str(told.value)
    assert "\n" not in str(told.value)
