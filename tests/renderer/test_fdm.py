"""Bumps in time, their gradients and their optimiser, against the formula in float64."""

from __future__ import annotations

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from renderer.deformation.fdm import (
    CENTRE,
    CHANNELS,
    FIRST,
    LAST,
    MAX_U,
    POSITION,
    WEIGHT,
    WIDTH,
    FlexibleMotion,
    add_bumps,
)
from renderer.gaussians import DynamicGaussians
from renderer.raw_gaussians import RawGaussians
from renderer.train.fdm_trainer import FdmRates, FdmTrainer
from renderer.train.initialize import round_gaussians
from renderer.train.methods.deform3dgs import FUNCTIONS, INITIAL_WIDTH
from renderer.train.rates import Rate

Float64Array = NDArray[np.float64]
NEGLIGIBLE = 1.2e-7
"""exp(-MAX_U^2) in float32."""


def distances(bumps: Float64Array, time: float) -> Float64Array:
    """u (B, N, C), literally."""
    result: Float64Array = (time - bumps[:, :, CENTRE]) ** 2 / (bumps[:, :, WIDTH] ** 2 + 1e-4)
    return result


def values(bumps: Float64Array, time: float) -> Float64Array:
    """Of the channels (N, C), literally."""
    result: Float64Array = (bumps[:, :, WEIGHT] * np.exp(-(distances(bumps, time) ** 2))).sum(axis=0)
    return result


def random_motion(seed: int = 0, count: int = 150, functions: int = 6) -> FlexibleMotion:
    rng = np.random.default_rng(seed)
    bumps = np.empty((functions, count, 3, CHANNELS), np.float32)
    bumps[:, :, WEIGHT] = rng.normal(size=(functions, count, CHANNELS))
    bumps[:, :, CENTRE] = rng.uniform(-0.1, 1.1, (functions, count, CHANNELS))
    bumps[:, :, WIDTH] = rng.choice([-1, 1], (functions, count, CHANNELS)) * 10 ** rng.uniform(
        -2.5, -0.3, (functions, count, CHANNELS)
    )
    return FlexibleMotion(bumps)


def balls(count: int) -> RawGaussians:
    rng = np.random.default_rng(1)
    means = rng.normal(size=(count, 3)).astype(np.float32)
    return round_gaussians(means, np.full(count, 0.1), means, 0.5)


def trainer(motion: FlexibleMotion, rate: float) -> FdmTrainer:
    return FdmTrainer(motion, FdmRates(position=Rate.constant(3 * rate), other=Rate.constant(rate)))


def gradients(count: int, seed: int) -> RawGaussians:
    """Random ones, by raw values."""
    rng = np.random.default_rng(seed)
    shapes = {"means": (3,), "quats": (4,), "log_scales": (3,), "opacity_logits": (), "colors": (3,)}
    drawn = {name: rng.normal(size=(count, *shape)).astype(np.float32) for name, shape in shapes.items()}
    return RawGaussians(**drawn, harmonics=np.zeros((count, 0, 3), np.float32))


def by_channel(by: RawGaussians) -> Float64Array:
    return np.concatenate([by.means, by.quats, by.log_scales], axis=1).astype(np.float64)


@given(st.floats(-0.5, 1.5), st.integers(0, 50))
def test_kernel_agrees_with_the_formula(time: float, seed: int) -> None:
    motion = random_motion(seed)
    got = np.zeros((150, CHANNELS), np.float32)
    add_bumps(motion.bumps, motion.spans, time, got)
    # The time itself is a float32 in the kernel.
    wanted = values(motion.bumps.astype(np.float64), float(np.float32(time)))
    assert np.abs(got - wanted).max() < 2e-5


@pytest.mark.parametrize("width", [0.0, 1e-30, 1e-4, 1.0, 1e4, 1e15])
@pytest.mark.parametrize("centre", [-1e10, 0.0, 0.5, 1e4, 1e15])
def test_stiff_bumps_are_finite_and_right(width: float, centre: float) -> None:
    """Widths whose square underflows or overflows, centres far beyond the clip."""
    bumps = np.full((1, 1, 3, CHANNELS), 2.0, np.float32)
    bumps[:, :, CENTRE], bumps[:, :, WIDTH] = centre, width
    got = np.zeros((1, CHANNELS), np.float32)
    motion = FlexibleMotion(bumps)
    add_bumps(motion.bumps, motion.spans, 0.5, got)
    assert np.allclose(got, values(bumps.astype(np.float64), 0.5), rtol=2e-3, atol=1e-6)
    before = bumps.copy()
    trainer(motion, 1e-3).update(0.5, gradients(1, 0), np.ones(1, bool), 0)
    assert np.isfinite(motion.bumps).all()
    assert np.abs(motion.bumps - before)[:, :, WEIGHT].max() < 0.1


def test_the_published_start_has_gaps() -> None:
    """Of Deform3DGS' 63 frames 27 have half of a bump and 16 have none; of 156 frames 68 and 40."""
    centres = np.linspace(0, 1, 17)
    for n_frames, supported, without in ((63, 27, 16), (156, 68, 40)):
        bumps = np.ones((17, 1, 3, 1))
        bumps[:, 0, CENTRE, 0], bumps[:, :, WIDTH] = centres, 0.01
        most = np.array(
            [np.exp(-(distances(bumps, index / n_frames) ** 2)).max() for index in range(n_frames)]
        )
        assert np.count_nonzero(most > 0.5) == supported
        assert np.count_nonzero(most < 1e-3) == without


@pytest.mark.parametrize("n_frames", [1, 5, 24, 63, 156, 1000])
def test_every_frame_time_has_support_at_our_start(n_frames: int) -> None:
    bumps = FlexibleMotion.at_rest(1, FUNCTIONS, INITIAL_WIDTH).bumps.astype(np.float64)
    for index in range(n_frames):
        assert np.exp(-(distances(bumps, index / n_frames) ** 2)).max() > 0.1


def test_nothing_moves_at_rest_and_what_does_not_deform_is_shared() -> None:
    raw = balls(70)
    moved = FlexibleMotion.at_rest(70, 5, 0.1).moved(raw, 0.3)
    assert all(np.array_equal(moved.arrays()[name], value) for name, value in raw.arrays().items())
    assert moved.colors is raw.colors
    assert moved.opacity_logits is raw.opacity_logits


def test_channels_move_position_quaternion_and_scale_in_this_order() -> None:
    raw, motion = balls(150), random_motion()
    moved = motion.moved(raw, 0.6)
    offsets = values(motion.bumps.astype(np.float64), 0.6)
    assert np.allclose(moved.means, raw.means + offsets[:, :3], atol=2e-5)
    assert np.allclose(moved.quats, raw.quats + offsets[:, 3:7], atol=2e-5)
    assert np.allclose(moved.log_scales, raw.log_scales + offsets[:, 7:], atol=2e-5)


def test_spans_hold_every_time_at_which_a_bump_counts() -> None:
    motion = random_motion()
    times = np.linspace(-1, 2, 301)
    counts = np.stack([distances(motion.bumps.astype(np.float64), time) <= MAX_U for time in times])
    inside = np.stack(
        [(motion.spans[..., FIRST] - 1e-6 <= t) & (t <= motion.spans[..., LAST] + 1e-6) for t in times]
    )
    assert not (counts.any(axis=3) & ~inside).any()
    assert 0.1 < inside.mean() < 0.9


def test_gradients_are_the_slopes_of_the_formula() -> None:
    """From moments at zero, one step leaves a tenth of the gradient in the first."""
    motion = random_motion()
    bumps, time = motion.bumps.astype(np.float64), 0.45
    by = gradients(150, 2)
    teacher = trainer(motion, 0.0)
    teacher.update(time, by, np.ones(150, bool), 0)
    got = teacher.state()["first.bumps"] * 10.0
    live = distances(bumps, float(np.float32(time))) <= MAX_U
    step = 1e-6
    for part in (WEIGHT, CENTRE, WIDTH):
        # Each function alone: channels of all Gaussians are apart from each other.
        for j in range(len(bumps)):
            ahead, behind = bumps.copy(), bumps.copy()
            ahead[j, :, part] += step
            behind[j, :, part] -= step
            slope = (values(ahead, time) - values(behind, time)) / (2 * step) * by_channel(by)
            wanted = np.where(live[j], slope, 0.0)
            scale = 1 + np.abs(wanted)
            assert (np.abs(got[j, :, part] - wanted) / scale).max() < 2e-3


def test_left_out_gradients_are_negligible() -> None:
    """What the optimiser does not see is below a float32's resolution of a whole bump's."""
    bumps = random_motion(3).bumps.astype(np.float64)
    beyond = distances(bumps, 0.5) > MAX_U
    assert beyond.any()
    assert np.exp(-(distances(bumps, 0.5)[beyond] ** 2)).max() < NEGLIGIBLE


def test_optimiser_is_adam_on_what_counts_and_leaves_the_rest() -> None:
    """Kingma & Ba, Algorithm 1, literally in float64, over three times that share some bumps."""
    motion = random_motion(5)
    start = motion.bumps.copy()
    teacher, rate = trainer(motion, 1e-3), np.full((3, CHANNELS), 1e-3)
    rate[WEIGHT, POSITION] = 3e-3
    seen = np.arange(150) % 3 != 0
    bumps, m, v = start.astype(np.float64), np.zeros(start.shape), np.zeros(start.shape)
    touched = np.zeros(start.shape, bool)
    for step, time in enumerate((0.3, 0.33, 0.7), start=1):
        by = gradients(150, step)
        teacher.update(time, by, seen, step - 1)
        u = distances(bumps, float(np.float32(time)))
        q = bumps[:, :, WIDTH] ** 2 + 1e-4
        g = by_channel(by) * np.exp(-(u**2))
        slope = 4 * bumps[:, :, WEIGHT] * g * u / q
        away = float(np.float32(time)) - bumps[:, :, CENTRE]
        gradient = np.stack([g, slope * away, slope * u * bumps[:, :, WIDTH]], axis=2)
        live = np.broadcast_to(((u <= MAX_U) & seen[None, :, None])[:, :, None], start.shape)
        m = np.where(live, 0.9 * m + 0.1 * gradient, m)
        v = np.where(live, 0.999 * v + 0.001 * gradient**2, v)
        change = rate * (m / (1 - 0.9**step)) / (np.sqrt(v / (1 - 0.999**step)) + 1e-15)
        bumps = np.where(live, bumps - change, bumps)
        touched |= live
    assert np.array_equal(motion.bumps[~touched], start[~touched])
    close = np.isclose(motion.bumps, bumps, atol=2e-5)
    # Where a gradient is near 0, the sign of its rounding decides the step.
    assert close[touched].mean() > 0.995
    assert (motion.bumps[touched] != start[touched]).mean() > 0.95


def test_spans_follow_the_bumps_as_they_train() -> None:
    motion = random_motion(6)
    teacher = trainer(motion, 0.02)
    for step in range(30):
        teacher.update(step / 30, gradients(150, step), np.ones(150, bool), step)
    assert np.array_equal(motion.spans, FlexibleMotion(motion.bumps.copy()).spans)


def test_a_curve_is_learned() -> None:
    """A swing that the bumps at rest cannot show comes out to 1 % of its height, 10 % at worst."""
    falling = Rate(1e-2, 1e-4, 4000)
    motion = FlexibleMotion.at_rest(1, FUNCTIONS, INITIAL_WIDTH)
    teacher, raw = FdmTrainer(motion, FdmRates(position=falling, other=falling)), balls(1)
    times = np.arange(63) / 63
    target = raw.means + np.sin(5 * times)[:, None, None].astype(np.float32)
    order = np.random.default_rng(0)
    by = gradients(1, 0)
    for step in range(4000):
        k = int(order.integers(63))
        moved = teacher.moved(raw, times[k])
        zero = {name: np.zeros_like(value) for name, value in by.arrays().items()}
        error = RawGaussians(**(zero | {"means": moved.means - target[k]}))
        teacher.update(times[k], error, np.ones(1, bool), step)
    between = np.linspace(0, times[-1], 200)
    errors = [np.abs(teacher.moved(raw, t).means - raw.means - np.sin(5 * t)).max() for t in between]
    assert np.mean(errors) < 0.01
    assert max(errors) < 0.1
    assert np.array_equal(teacher.moved(raw, 0.5).quats, raw.quats)


def test_chosen_rows_move_as_before_and_keep_their_moments() -> None:
    raw, teacher = balls(150), trainer(random_motion(7), 1e-3)
    teacher.update(0.4, gradients(150, 1), np.ones(150, bool), 0)
    whole, moments = teacher.moved(raw, 0.5), teacher.state()["second.bumps"]
    index = np.array([149, 3, 3, 77])
    teacher.choose(index)
    assert np.array_equal(teacher.moved(raw.rows(index), 0.5).means, whole.means[index])
    assert np.array_equal(teacher.state()["second.bumps"], moments[:, index])


def test_restored_trainer_goes_on_as_if_never_interrupted() -> None:
    ours, other = trainer(random_motion(8), 1e-2), trainer(random_motion(9, count=20), 1e-2)
    ours.update(0.4, gradients(150, 1), np.ones(150, bool), 0)
    other.restore(ours.state())
    for teacher in (ours, other):
        teacher.update(0.42, gradients(150, 2), np.ones(150, bool), 1)
    assert all(np.array_equal(value, other.state()[name]) for name, value in ours.state().items())


def test_number_of_threads_does_not_matter() -> None:
    before = numba.get_num_threads()
    results = []
    try:
        for threads in {1, before}:
            numba.set_num_threads(threads)
            teacher = trainer(random_motion(10), 1e-2)
            for step in range(3):
                teacher.update(0.2 * step, gradients(150, step), np.ones(150, bool), step)
            results.append(teacher.motion.bumps.tobytes() + teacher.moved(balls(150), 0.3).means.tobytes())
    finally:
        numba.set_num_threads(before)
    assert len(set(results)) == 1


def test_files_know_the_motion_by_its_bumps() -> None:
    model = DynamicGaussians(balls(150), random_motion())
    again = DynamicGaussians.from_arrays(model.arrays())
    assert isinstance(again.motion, FlexibleMotion)
    assert np.array_equal(again.at(0.7).means, model.at(0.7).means)
    assert np.array_equal(again.rows(np.array([5])).at(0.7).means, model.at(0.7).means[[5]])
