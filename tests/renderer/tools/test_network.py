"""The small network: right slopes, what a straight line cannot tell apart, the same each time."""

from __future__ import annotations

import numpy as np
import pytest

from renderer.tools import network
from renderer.tools.network import BATCH, _first_layers, _forward, _slopes, train_network


def test_slopes_are_those_of_finite_differences() -> None:
    random = np.random.default_rng(3)
    layers = tuple((w.astype(np.float64), b.astype(np.float64) + 0.1) for w, b in _first_layers(random, 4))
    inputs, wanted = random.normal(0, 1, (7, 4)), (random.random(7) > 0.5).astype(np.float64)

    def loss() -> float:
        z = _forward(layers, inputs)[-1][:, 0]  # type: ignore[arg-type]
        return float(np.mean(np.logaddexp(0, z) - wanted * z))

    found = _slopes(layers, inputs, wanted)  # type: ignore[arg-type]
    arrays = [array for layer in layers for array in layer]
    for array, slope in zip(arrays, found, strict=True):
        for place in [(0,) * array.ndim, tuple(side - 1 for side in array.shape)]:
            kept, step = array[place], 1e-6
            array[place] = kept + step
            above = loss()
            array[place] = kept - step
            below = loss()
            array[place] = kept
            assert slope[place] == pytest.approx((above - below) / (2 * step), abs=1e-6)


def test_it_tells_apart_what_no_line_does(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(network, "STEPS", 600)
    random = np.random.default_rng(0)
    values = random.uniform(-1, 1, (4000, 2)).astype(np.float32)
    kinds = values[:, 0] * values[:, 1] > 0
    learned, again = train_network(values, kinds), train_network(values, kinds)
    fresh = random.uniform(-1, 1, (3 * BATCH + 5, 2)).astype(np.float32)
    found = learned.probability(fresh)
    assert np.mean((found > 0.5) == (fresh[:, 0] * fresh[:, 1] > 0)) > 0.95
    np.testing.assert_array_equal(found, again.probability(fresh))
    assert learned.probability(fresh[:0]).shape == (0,)


def test_extreme_features_leave_it_finite() -> None:
    random = np.random.default_rng(0)
    values = random.normal(0, 1, (500, 3)).astype(np.float32)
    values[:, 2] = 7.0
    values[0] = 1e30
    found = train_network(values, random.random(500) > 0.5).probability(values)
    assert np.isfinite(found).all()
