"""A run that goes wrong says so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from renderer.raw_gaussians import RawGaussians
from renderer.train.guards import JUDGED, LossWatch, hold_scales, leave_out_broken
from renderer.train.trainer import TrainingError, train
from tests.renderer.sheet import SMALL, moving_sheet

RATES = (
    "mean_rate", "motion_rate", "color_rate", "color_motion_rate", "opacity_rate", "scale_rate", "quat_rate"
)  # fmt: skip


def gradients(count: int) -> RawGaussians:
    shapes = {"means": (3,), "quats": (4,), "log_scales": (3,), "opacity_logits": (), "colors": (3,)}
    arrays = {name: np.ones((count, *tail), np.float32) for name, tail in shapes.items()}
    return RawGaussians(**arrays, harmonics=np.zeros((count, 0, 3), np.float32))


@pytest.mark.parametrize("name", ["means", "quats", "log_scales", "opacity_logits", "colors"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_gradient_that_is_no_number_is_left_out_alone(name: str, value: float) -> None:
    by, seen = gradients(6), np.array([True, True, False, True, True, True])
    flat = getattr(by, name).reshape(6, -1)
    flat[3, -1] = value
    flat[2, 0] = value
    assert leave_out_broken(by, seen) == 1
    assert seen.tolist() == [True, True, False, False, True, True]


def test_scales_that_run_away_are_held() -> None:
    log_scales = np.float32([[0, 1, 2], [-80, 0, 88]])
    assert hold_scales(log_scales, 50.0) == 2
    assert np.isfinite(np.exp(log_scales)).all()
    assert log_scales[0].tolist() == [0, 1, 2]
    assert hold_scales(log_scales, 50.0) == 0


def test_a_loss_that_rises_for_good_is_a_problem_and_one_that_swings_is_not() -> None:
    rng = np.random.default_rng(0)
    calm, wild = LossWatch(), LossWatch()
    for step in range(3 * JUDGED):
        calm.add(0.1 * rng.uniform(0.2, 3.0))
        wild.add(0.1 * (1 + 5 * step / JUDGED))
    assert calm.problem is None
    assert wild.problem is not None
    wild.add(float("nan"))
    assert wild.problem == "the loss is not finite"


def test_rates_a_hundred_times_too_high_end_in_one_clear_line() -> None:
    config = replace(SMALL, **{name: min(1.0, 100 * getattr(SMALL, name)) for name in RATES})
    with pytest.raises(TrainingError, match="lower the learning rates"):
        list(train(moving_sheet(), config))
