"""How long the rest of a training takes, on a clock that the test moves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from renderer.train import meter as metering
from renderer.train.losses import Measured
from renderer.train.meter import FULL_COST, Meter
from renderer.train.recipe import Stage

STEP = 0.1
"""Seconds at half resolution."""


@dataclass
class Clock:
    now: float = 0.0

    def perf_counter(self) -> float:
        return self.now


class Halves:
    """Of a recipe of as many steps at half as at full resolution what the meter asks for."""

    def __init__(self, steps: int) -> None:
        self.iterations = 2 * steps
        self.stages = Stage(steps=steps, half=True), Stage(steps=steps)


def seconds_of(iteration: int, steps: int) -> float:
    return STEP if iteration < steps else STEP * FULL_COST


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(metering, "time", clock)
    return clock


def run(clock: Clock, steps: int, done: int, after: float, slow: dict[int, float]) -> float:
    """Seconds left after `done` steps; some take so much longer."""
    meter = Meter(Halves(steps), 0.0, after)  # type: ignore[arg-type]
    result = Measured(0.1, 0.01)
    for iteration in range(done):
        with meter.between():
            clock.now += 0.01
        took = seconds_of(iteration, steps) + slow.get(iteration, 0.0)
        clock.now += took
        meter.add(result, iteration, took, 100)
    return meter.progress(done).seconds_left


@pytest.mark.parametrize("done", [100, 200, 300, 399])
def test_the_time_left_is_that_of_steps_of_both_sizes_of_what_is_between_and_after(
    clock: Clock, done: int
) -> None:
    """Also beside a compilation of 60 s in the first step, and one of 20 s in a later one."""
    left = run(clock, 200, done, 40, {0: 60.0, 3: 20.0})
    true = sum(seconds_of(iteration, 200) + 0.01 for iteration in range(done, 400)) + 40 * STEP * FULL_COST
    assert left == pytest.approx(true, rel=0.1)


def test_a_model_that_grows_is_told_by_its_recent_steps(clock: Clock) -> None:
    growing = {iteration: 0.1 * iteration / 200 for iteration in range(200)}
    left = run(clock, 200, 200, 0, growing)
    flat = run(clock, 200, 200, 0, {})
    assert left > 1.6 * flat  # Twice as slow at the end as at the start.


def test_before_the_second_step_nothing_is_known(clock: Clock) -> None:
    assert run(clock, 200, 1, 40, {0: 60.0}) == 0
    assert np.isfinite(run(clock, 200, 2, 40, {0: 60.0}))
