"""What moves Gaussians in time by bumps (Deform3DGS), and its training."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from renderer.deformation.fdm import (
    CENTRE,
    CHANNELS,
    POSITION,
    QUATERNION,
    SCALE,
    WEIGHT,
    WIDTH,
    FlexibleMotion,
    add_bumps,
)
from renderer.measuring.stability import exact_adam
from renderer.measuring.stability.row import Row, worst
from renderer.measuring.stability.scenes import noisy_gradients, ordinary, raw_of
from renderer.train.fdm_trainer import FdmRates, FdmTrainer
from renderer.train.rates import Rate

FloatArray = NDArray[np.float64]
HAZARD = "bumps in time (FDM)"
TIMES = (0.0, 1e-9, 0.1, 0.5, 1 - 1e-9, 1.0)
FUNCTIONS, GAUSSIANS = 17, 3
RATE, POSITION_RATE = 1e-3, 3e-3
STEP = 1e-6
"""Of the differences that the slopes of the formula are."""
REACH = 4.0
"""u, beyond which a bump rests."""


def rows() -> Iterator[Row]:
    """The sum of bumps against its formula, in units of the sum of the absolute weights; and its training."""
    cases = {
        "width -> 0": (0.0, 1.0),
        "width of 1e-20": (1e-20, 1.0),
        "width of 1e4": (1e4, 1.0),
        "negative width": (-0.1, 1.0),
        "weight of 1e6": (0.06, 1e6),
        "width 0, weight 1e6": (0.0, 1e6),
    }
    for name, (width, weight) in cases.items():
        motion, errors = FlexibleMotion(_bumps(width, weight)), []
        exact = motion.bumps.astype(np.float64)
        size = np.abs(exact[:, :, WEIGHT]).sum(axis=0)
        for time in (*TIMES, float(motion.bumps[3, 0, CENTRE, 0])):
            got = np.zeros((GAUSSIANS, CHANNELS), np.float32)
            add_bumps(motion.bumps, motion.spans, time, got)
            errors.append(float((np.abs(got - _values(exact, time).sum(axis=0)) / size).max()))
        yield Row(HAZARD, name, worst(errors), 1e-6, "of the weights",
                  "1e-4 is added to the squared width, as published" if width == 0 else "")  # fmt: skip
    yield _moved()
    yield from _trained()


def _bumps(width: float, weight: float) -> NDArray[np.float32]:
    """Random weights, centres evenly in time."""
    bumps = np.zeros((FUNCTIONS, GAUSSIANS, 3, CHANNELS), np.float32)
    bumps[:, :, CENTRE] = np.linspace(0, 1, FUNCTIONS)[:, None, None]
    bumps[:, :, WIDTH] = width
    bumps[:, :, WEIGHT] = weight * np.random.default_rng(0).normal(size=(FUNCTIONS, GAUSSIANS, CHANNELS))
    return bumps


def _values(bumps: FloatArray, time: float) -> FloatArray:
    """(B, N, C) of each bump."""
    return np.asarray(bumps[:, :, WEIGHT] * np.exp(-(_u(bumps, time) ** 2)))


def _u(bumps: FloatArray, time: float) -> FloatArray:
    return np.asarray((time - bumps[:, :, CENTRE]) ** 2 / (bumps[:, :, WIDTH] ** 2 + 1e-4))


def _moved() -> Row:
    """Each channel goes where it belongs."""
    raw = raw_of(ordinary(GAUSSIANS))
    motion = FlexibleMotion(_bumps(0.06, 1.0))
    moves = _values(motion.bumps.astype(np.float64), 0.37).sum(axis=0)
    got = motion.moved(raw, 0.37)
    apart = np.concatenate([
        got.means - raw.means - moves[:, POSITION],
        got.quats - raw.quats - moves[:, QUATERNION],
        got.log_scales - raw.log_scales - moves[:, SCALE],
    ], axis=1)  # fmt: skip
    return Row(HAZARD, "Gaussians that they move", float(np.abs(apart).max()), 1e-5, "of 1")


def _trained() -> Iterator[Row]:
    """20 steps of noisy gradients at random times, against Adam in float64 by differences of the formula."""
    rng, raw = np.random.default_rng(8), raw_of(ordinary(GAUSSIANS))
    rates = FdmRates(position=Rate.constant(POSITION_RATE), other=Rate.constant(RATE))
    trainer = FdmTrainer(FlexibleMotion(_bumps(0.06, 1.0)), rates)
    exact = trainer.motion.bumps.astype(np.float64)
    first, second = np.zeros_like(exact), np.zeros_like(exact)
    rate = np.full((3, CHANNELS), RATE)
    rate[WEIGHT, POSITION] = POSITION_RATE
    for iteration, time in enumerate(rng.uniform(0, 1, 20)):
        by = noisy_gradients(raw, rng)
        seen = rng.uniform(size=GAUSSIANS) < 0.8
        trainer.update(time, by, seen, iteration)
        channels = np.concatenate([by.means, by.quats, by.log_scales], axis=1).astype(np.float64)
        counts = np.broadcast_to((_u(exact, time) <= REACH)[:, :, None] & seen[:, None, None], exact.shape)
        now = exact_adam.moved(
            exact, channels[:, None] * _slopes(exact, time), (first, second), rate, iteration + 1
        )
        for old, new in zip((exact, first, second), now, strict=True):
            np.copyto(old, new, where=counts)
    for part, name in ((WEIGHT, "weights"), (CENTRE, "centres"), (WIDTH, "widths")):
        apart = np.abs(trainer.motion.bumps[:, :, part] - exact[:, :, part]) / rate[part]
        yield Row(HAZARD, f"20 training steps: {name}", float(apart.max()), 0.05, "steps")


def _slopes(bumps: FloatArray, time: float) -> FloatArray:
    """(B, N, 3, C) of the values by weight, centre and width, from central differences."""
    out = np.empty_like(bumps)
    for part in (WEIGHT, CENTRE, WIDTH):
        sides = []
        for step in (STEP, -STEP):
            moved = bumps.copy()
            moved[:, :, part] += step
            sides.append(_values(moved, time))
        out[:, :, part] = (sides[0] - sides[1]) / (2 * STEP)
    return out
