from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from renderer.gaussians import DynamicGaussians
from renderer.measuring.training_accuracy import _shows, motion_rmse, outcome
from renderer.phantom import Phantom, PhantomParams, write_phantom
from renderer.raw_gaussians import RawGaussians
from renderer.sources import open_clip
from renderer.train.config import TrainConfig
from renderer.train.events import Finished
from renderer.train.initialize import round_gaussians
from renderer.train.training import train
from tests.benchmarks.train_settings import settings

PARAMS = PhantomParams(n_frames=10, width=96, height=72)


@cache
def phantom() -> Phantom:
    return Phantom(PARAMS)


@dataclass(frozen=True)
class OfTissue:
    """Goes `share` of the way that the tissue at `material` goes."""

    material: np.ndarray
    share: float

    def moved(self, raw: RawGaussians, time: float) -> RawGaussians:
        u, v = self.material.T
        start, now = (phantom().surface.evaluate(u, v, when)[0] for when in (0.0, time))
        return replace(raw, means=(start + self.share * (now - start)).astype(np.float32))

    def arrays(self) -> dict[str, Any]:
        return {}


def model(share: float) -> DynamicGaussians:
    """A Gaussian at every second pixel of the tissue that the first frame sees, and beyond."""
    axis = np.arange(-60, 60, 0.9)
    material = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    start, _, _ = phantom().surface.evaluate(*material.T, 0.0)  # type: ignore[call-arg]
    count = len(material)
    raw = round_gaussians(
        start.astype(np.float32), np.full(count, 0.7), np.zeros((count, 3), np.float32), 0.95
    )
    return DynamicGaussians(raw, OfTissue(material, share))  # type: ignore[arg-type]


def true_way(indices: tuple[int, ...]) -> float:
    squares = []
    for index in indices:
        view = phantom().view(index)
        u, v = view.material[view.frame.evaluation_mask].T
        later = (index + 5) % 10 / 10
        began, ended = (phantom().surface.evaluate(u, v, when)[0] for when in (view.frame.time, later))
        squares.append(np.mean(np.sum((ended - began) ** 2, axis=1)))
    return float(np.sqrt(np.mean(squares)))


@pytest.mark.parametrize("share", [1.0, 0.5, 0.0])
def test_motion_error_is_what_a_model_lacks_of_the_true_way(share: float) -> None:
    indices = (1, 4, 9)
    expected = (1 - share) * true_way(indices)
    assert true_way(indices) > 3
    assert motion_rmse(model(share), phantom(), indices) == pytest.approx(expected, abs=0.2)


def test_the_first_setting_is_the_default_and_none_comes_twice() -> None:
    configs = [config for _, config in settings()]
    assert configs[0] == TrainConfig()
    assert len(set(configs)) == len(configs)


@pytest.mark.parametrize("camera", ["fixed", "moving"])
def test_tissue_is_shown_where_a_view_has_it_before_its_tools(camera: Any) -> None:
    truth = Phantom(replace(PARAMS, camera=camera))
    for index in (0, 7):
        view = truth.view(index)
        points = view.material.reshape(-1, 2)
        assert np.array_equal(_shows(view, truth, points), view.frame.tissue_mask.ravel())
        assert not _shows(view, truth, points + 1000).any()
    # A breath later, the same tissue is elsewhere.
    moved = _shows(truth.view(7), truth, truth.view(0).material.reshape(-1, 2))
    assert 0 < (moved != truth.view(7).frame.tissue_mask.ravel()).mean() < 0.3


def test_an_outcome_measures_all_that_the_phantom_knows(tmp_path: Any) -> None:
    write_phantom(tmp_path / "clip", PARAMS)
    clip = open_clip(tmp_path / "clip")
    moving = TrainConfig(iterations=120, n_gaussians=1500)
    configs = moving, replace(moving, method="static")
    runs = [event for config in configs for event in train(clip, config) if isinstance(event, Finished)]
    trained, still = (outcome(*pair, phantom()) for pair in zip(runs, (clip, clip), configs, strict=True))
    assert trained.psnr > still.psnr
    assert trained.motion_rmse < still.motion_rmse
    assert still.motion_rmse == pytest.approx(true_way(clip.test_indices), rel=0.05)
    assert 0 < trained.depth_rmse < 3
    assert still.megabytes < trained.megabytes
    unknown = outcome(runs[0], clip, moving)
    assert np.isnan(unknown.motion_rmse)
    assert np.isnan(unknown.psnr_behind_tools)
    assert trained.coverage > 0.9
    assert 15 < trained.psnr_behind_tools < trained.psnr_tissue
    assert trained.psnr_tissue == pytest.approx(trained.psnr_masked)  # Depth is known on all its tissue.
