"""A small neural network that tells two kinds of pixels apart, trained in a second on the CPU."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float32]

HIDDEN: Final = 24
"""Units in each of the two hidden layers."""
STEPS: Final = 2000
BATCH: Final = 448
"""Rows of a product: BLAS makes small ones in the thread that asks, and others wait for busy threads."""
RATE: Final = 3e-3
"""Of Adam, falling to nothing."""
DECAY: Final = 1e-4
"""Of weights, a step."""
FARTHEST: Final = 4.0
"""Standard deviations from the mean beyond which a feature counts as no farther."""
_BETAS = 0.9, 0.999
_STEEPEST = 30.0


@dataclass(frozen=True, eq=False)
class Network:
    """Two hidden layers of rectified linear units over standardised features; one output."""

    mean: Values
    spread: Values
    """(F,) each, of the features it was trained on."""
    layers: tuple[tuple[Values, Values], ...]
    """Weights (inputs, outputs) and biases (outputs,), first layer first."""

    def probability(self, features: Values) -> Values:
        """(N,) in [0, 1] that each of (N, F) is of the second kind."""
        parts = range(0, len(features), BATCH)
        found = (_forward(self.layers, self._standardised(features[at : at + BATCH]))[-1] for at in parts)
        return _sigmoid(np.concatenate([np.zeros((0, 1), np.float32), *found])[:, 0])

    def _standardised(self, features: Values) -> Values:
        standardised = (features - self.mean) / self.spread
        return np.asarray(np.clip(standardised, -FARTHEST, FARTHEST), dtype=np.float32)


def train_network(features: Values, kinds: NDArray[np.bool_]) -> Network:
    """Adam on the cross-entropy of (N, F) features of known kinds (N,); the same for the same input.

    Kingma & Ba, Adam, 2015; He et al., Delving deep into rectifiers, 2015 (first weights).
    """
    random = np.random.default_rng(0)
    wide = features.astype(np.float64)
    mean, spread = wide.mean(axis=0).astype(np.float32), (wide.std(axis=0) + 1e-6).astype(np.float32)
    network = Network(mean, spread, _first_layers(random, features.shape[1]))
    inputs, wanted = network._standardised(features), kinds.astype(np.float32)
    values = [array for layer in network.layers for array in layer]
    first, second = ([np.zeros_like(value) for value in values] for _ in range(2))
    for step in range(1, STEPS + 1):
        chosen = random.integers(0, len(inputs), BATCH)
        slopes = _slopes(network.layers, inputs[chosen], wanted[chosen])
        rate = RATE * (1 - step / STEPS)
        for value, slope, mean_slope, mean_square in zip(values, slopes, first, second, strict=True):
            slope = slope + DECAY * value
            mean_slope += (1 - _BETAS[0]) * (slope - mean_slope)
            mean_square += (1 - _BETAS[1]) * (slope**2 - mean_square)
            unbiased = mean_slope / (1 - _BETAS[0] ** step), mean_square / (1 - _BETAS[1] ** step)
            value -= rate * unbiased[0] / (np.sqrt(unbiased[1]) + 1e-8)
    return network


def _first_layers(random: np.random.Generator, count: int) -> tuple[tuple[Values, Values], ...]:
    sizes = (count, HIDDEN, HIDDEN, 1)
    return tuple(
        (
            random.normal(0, np.sqrt(2 / before), (before, after)).astype(np.float32),
            np.zeros(after, np.float32),
        )
        for before, after in pairwise(sizes)
    )


def _forward(layers: tuple[tuple[Values, Values], ...], inputs: Values) -> list[Values]:
    """The inputs and what each layer makes of them; the last one is not rectified."""
    made = [inputs]
    for place, (weights, biases) in enumerate(layers, start=1):
        out = made[-1] @ weights + biases
        made.append(out if place == len(layers) else np.maximum(out, 0))
    return made


def _slopes(layers: tuple[tuple[Values, Values], ...], inputs: Values, wanted: Values) -> list[Values]:
    """Of the mean cross-entropy, by weights and biases in the order of the layers."""
    made = _forward(layers, inputs)
    back = (_sigmoid(made[-1]) - wanted[:, None]) / np.float32(len(inputs))
    slopes: list[Values] = []
    for place in range(len(layers) - 1, -1, -1):
        slopes = [made[place].T @ back, back.sum(axis=0), *slopes]
        if place:
            back = (back @ layers[place][0].T) * (made[place] > 0)
    return slopes


def _sigmoid(values: Values) -> Values:
    return np.asarray(1 / (1 + np.exp(-np.clip(values, -_STEEPEST, _STEEPEST))), dtype=np.float32)
