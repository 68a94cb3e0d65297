"""The mean of a model over its last steps: exact, in the checkpoint, and off where nothing asks for it."""

from __future__ import annotations

import numpy as np
import pytest

from renderer.deformation.motion import Still
from renderer.gaussians import DynamicGaussians
from renderer.raw_gaussians import RawGaussians
from renderer.stored_arrays import Arrays
from renderer.train.average import COUNT, EVERY, Average


def model(seed: int) -> DynamicGaussians:
    random = np.random.default_rng(seed)

    def drawn(*shape: int) -> np.ndarray:
        return random.normal(size=(5, *shape)).astype(np.float32)

    raw = RawGaussians(
        means=drawn(3), quats=drawn(4), log_scales=drawn(3), opacity_logits=drawn(), colors=drawn(3),
        harmonics=np.zeros((5, 0, 3), np.float32),
    )  # fmt: skip
    return DynamicGaussians(raw, Still())


def taken(average: Average, first: int, last: int) -> None:
    for done in range(first, last + 1):
        average.add(model(done), done)


def kept(average: Average, done: int) -> Arrays:
    """As a checkpoint has it, beside the model."""
    return model(done).arrays() | {name: value.copy() for name, value in average.state().items()}


def test_it_is_the_mean_of_every_fifth_of_the_last_steps_and_the_last_among_them() -> None:
    average = Average(iterations=43, steps=12)
    taken(average, 1, 43)
    counted = [model(done) for done in (33, 38, 43)]
    found = average.of(model(0))
    for name, value in found.arrays().items():
        expected = np.mean([one.arrays()[name].astype(np.float64) for one in counted], axis=0)
        assert value == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("cut", range(30, 44))
def test_a_checkpoint_at_any_step_goes_on_bit_for_bit(cut: int) -> None:
    whole, first, second = (Average(iterations=43, steps=12) for _ in range(3))
    taken(whole, 1, 43)
    taken(first, 1, cut)
    second.restore(kept(first, cut))
    taken(second, cut + 1, 43)
    for name, value in whole.of(model(0)).arrays().items():
        assert np.array_equal(second.of(model(0)).arrays()[name], value)


def test_without_steps_the_model_is_what_it_is() -> None:
    average = Average(iterations=20, steps=0)
    taken(average, 1, 20)
    last = model(7)
    assert average.of(last) is last
    assert average.state() == {}


def test_models_that_change_later_do_not_change_the_mean() -> None:
    average, one = Average(iterations=EVERY, steps=1), model(1)
    average.add(one, EVERY)
    kept = one.means.copy()
    one.means[:] = 9.0
    assert np.array_equal(average.of(one).means, kept)


def test_a_damaged_mean_is_refused() -> None:
    average = Average(iterations=10, steps=5)
    taken(average, 1, 10)
    state = kept(average, 10)
    for name, value in (("average.means", np.zeros((5, 2), np.float32)), (COUNT, np.zeros(1, np.float32))):
        with pytest.raises(ValueError, match="expected"):
            Average(iterations=10, steps=5).restore({**state, name: value})
    without = {name: value for name, value in state.items() if name != "average.quats"}
    with pytest.raises(ValueError, match="expected"):
        Average(iterations=10, steps=5).restore(without)
