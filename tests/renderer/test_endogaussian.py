"""The method as a whole on a small scene: from sampled tissue at rest to a HexPlane that moves it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from renderer.deformation.hexplane_motion import HexplaneMotion
from renderer.train import trainer
from renderer.train.config import TrainConfig
from renderer.train.methods.endogaussian import recipe
from renderer.train.training import train
from tests.renderer.sheet import finished, moving_sheet, needs_of, same_bytes

SMALL = TrainConfig(
    method="endogaussian", iterations=150, n_gaussians=500, checkpoint_every=60, hold_out=True
)
NEEDS = needs_of(moving_sheet(), SMALL)


def held_out_psnr(config: TrainConfig, unit: float = 1.0) -> float:
    """Of a sheet that hardly slides: the published rates are for slow motion."""
    return finished(moving_sheet(unit, shift=1.0), config)[1]


def test_motion_is_learned(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same in all but the motion, and for as long, is far from as good."""
    moving = held_out_psnr(SMALL)
    method = recipe(SMALL, NEEDS)
    at_rest = replace(method, stages=tuple(replace(stage, moves=False) for stage in method.stages))
    monkeypatch.setattr(trainer, "recipe_for", lambda config, needs: at_rest)
    assert moving > held_out_psnr(SMALL) + 1


def test_units_do_not_matter() -> None:
    """Metres or millimetres: the same picture quality from the same settings."""
    config = replace(SMALL, iterations=90)
    assert held_out_psnr(config, unit=1e-3) == pytest.approx(held_out_psnr(config), abs=0.3)


def test_a_run_that_goes_on_in_either_stage_ends_as_one_that_was_not_interrupted(tmp_path: Path) -> None:
    clip, config = moving_sheet(), replace(SMALL, iterations=60, checkpoint_every=15)
    whole, _ = finished(clip, config)
    for stop in (15, 45):  # Of 20 steps at rest and 60 that move.
        for _ in train(clip, config, folder=tmp_path, resume=True):
            if (tmp_path / f"checkpoint-{stop:07d}.safetensors").exists():
                break
    resumed, _ = finished(clip, config, folder=tmp_path, resume=True)
    assert same_bytes(whole, resumed)


def test_gaussians_are_drawn_once_each_and_reach_their_neighbours() -> None:
    frames = [moving_sheet().read_frame(index) for index in (0, 2, 3)]
    raw = recipe(SMALL, NEEDS).initialize(frames)
    assert len(np.unique(raw.means, axis=0)) == len(raw) == SMALL.n_gaussians
    assert np.allclose(raw.splats().opacities, 0.1)
    apart = np.linalg.norm(raw.means[:, None] - raw.means[None], axis=2)
    three = np.sort(apart, axis=1)[:, 1:4]
    assert np.allclose(np.exp(raw.log_scales), np.sqrt((three**2).mean(axis=1))[:, None], rtol=1e-3)


def test_a_single_gaussian_has_a_place_in_the_order_over_the_view() -> None:
    """It spans no height by which to sort."""
    frames = [moving_sheet().read_frame(0)]
    assert len(recipe(replace(SMALL, n_gaussians=1), NEEDS).initialize(frames)) == 1


def test_the_planes_are_as_fine_as_the_gaussians_are_many_and_hold_all_of_them() -> None:
    frames = [moving_sheet().read_frame(index) for index in (0, 2, 3)]
    method = recipe(SMALL, NEEDS)
    raw = method.initialize(frames)
    motion = method.make_trainer(raw, frames, 50.0).motion
    assert isinstance(motion, HexplaneMotion)
    assert sum(value.size for value in motion.arrays().values()) < 1e6
    assert (motion.box[0] <= raw.means).all()
    assert (raw.means <= motion.box[1]).all()


def test_a_quarter_of_the_steps_is_at_rest_on_the_first_frame() -> None:
    rest, moving = recipe(TrainConfig(method="endogaussian", iterations=3000), NEEDS).stages
    assert (rest.steps, rest.moves, rest.first_frame_only) == (1000, False, True)
    assert (moving.steps, moving.moves, moving.first_frame_only) == (3000, True, False)
