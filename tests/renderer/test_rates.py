"""Learning rates over a run, and which of them come to rest."""

from __future__ import annotations

from dataclasses import replace

import pytest

from renderer.measuring.stability.steps import NEEDS
from renderer.train.config import TrainConfig
from renderer.train.methods.vesselsplat import row_rates, spline_rates
from renderer.train.rates import Rate


def test_a_rate_falls_log_linearly_after_it_was_held() -> None:
    rate = Rate(1e-2, 1e-4, 100, held=50)
    assert [rate.at(at) for at in (0, 50, 75, 100, 1000)] == pytest.approx([1e-2, 1e-2, 1e-3, 1e-4, 1e-4])
    assert Rate(1e-2, 1e-4, 100).at(50) == pytest.approx(1e-3)
    assert Rate(0.0, 0.0, 10, held=5).at(7) == 0.0


def test_positions_come_to_rest_where_nothing_moves_and_frames_are_several() -> None:
    config = TrainConfig()
    moving, one_frame = row_rates(config, NEEDS).means, row_rates(config, replace(NEEDS, moves=False)).means
    resting = row_rates(config, replace(NEEDS, moves=False, rests=True)).means
    last, middle = config.iterations, config.iterations // 2
    assert moving.at(0) / moving.at(last) == pytest.approx(config.rate_decay)
    assert one_frame.at(0) / one_frame.at(last) == pytest.approx(config.rate_decay)
    assert resting.at(0) == resting.at(middle) == one_frame.at(0) == config.motion_rate
    assert resting.at(last) < one_frame.at(last) / 10


@pytest.mark.parametrize(("steps", "fall"), [(60, 3.0), (900, 3.0), (3000, 10.0), (6000, 20.0)])
def test_positions_on_curves_settle_the_more_the_longer_a_run_is(steps: int, fall: float) -> None:
    rates = spline_rates(TrainConfig(iterations=steps), 50.0)
    assert rates.position.at(0) == 50 * TrainConfig().motion_rate
    assert rates.position.at(0) / rates.position.at(steps) == pytest.approx(fall)
    assert rates.color.at(0) / rates.color.at(steps) == pytest.approx(TrainConfig().rate_decay)
