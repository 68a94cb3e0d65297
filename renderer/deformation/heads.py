"""The small network that turns features of a HexPlane into offsets of position, log-scale and quaternion.

One linear layer of 32, shared; then for each of the three a ReLU, a linear layer of 32, a ReLU and a
linear layer (EndoGaussian, after Wu et al. 2023). A row's result depends on that row alone, so that what is
kept moves as before where others are deleted. Gradients by the weights are summed over blocks that are small
enough for the matrix library to stay on one thread: so results repeat bit for bit.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from renderer.deformation.row_products import row_products
from renderer.splats import Float32Array

WIDTH = 32
PARTS = (slice(0, 3), slice(3, 6), slice(6, 10))
"""Columns of the offsets: position, log-scale, quaternion."""
OFFSETS = 10
ROWS = 64
"""Of a block."""


class Activations(NamedTuple):
    """What the backward pass needs, all (P, ...) with P a multiple of ROWS."""

    features: Float32Array
    trunk: Float32Array
    """(P, WIDTH), after the ReLU that the heads begin with."""
    hidden: Float32Array
    """(P, 3 WIDTH), after the ReLU, head by head."""


@dataclass(frozen=True, eq=False)
class Heads:
    """Weights; or, of the same shapes, gradients by them."""

    trunk_weight: Float32Array
    """(F, WIDTH)"""
    trunk_bias: Float32Array
    hidden_weight: Float32Array
    """(WIDTH, 3 WIDTH)"""
    hidden_bias: Float32Array
    output_weight: Float32Array
    """(WIDTH, OFFSETS), each column fed by its own head."""
    output_bias: Float32Array

    @classmethod
    def random(cls, n_features: int, rng: np.random.Generator) -> Self:
        """Weights by Glorot & Bengio 2010, Eq 16; biases uniform within 1 / sqrt(inputs)."""

        def uniform(bound: float, *shape: int) -> Float32Array:
            return rng.uniform(-bound, bound, shape).astype(np.float32)

        def weight(inputs: int, outputs: int) -> Float32Array:
            return uniform((6 / (inputs + outputs)) ** 0.5, inputs, outputs)

        widths = [part.stop - part.start for part in PARTS]
        return cls(
            trunk_weight=weight(n_features, WIDTH),
            trunk_bias=uniform(n_features**-0.5, WIDTH),
            hidden_weight=np.concatenate([weight(WIDTH, WIDTH) for _ in PARTS], axis=1),
            hidden_bias=uniform(WIDTH**-0.5, len(PARTS) * WIDTH),
            output_weight=np.concatenate([weight(WIDTH, width) for width in widths], axis=1),
            output_bias=uniform(WIDTH**-0.5, OFFSETS),
        )

    def offsets(self, features: Float32Array) -> tuple[Float32Array, Activations]:
        """Offsets (P, OFFSETS) of features (P, F), P a multiple of ROWS."""
        trunk = _rectified(row_products(features, self.trunk_weight) + self.trunk_bias)
        hidden = _rectified(row_products(trunk, self.hidden_weight) + self.hidden_bias)
        parts = [row_products(hidden[:, own], self.output_weight[:, part]) for own, part in _pairs()]
        return np.concatenate(parts, axis=1) + self.output_bias, Activations(features, trunk, hidden)

    def backward(self, by_offsets: Float32Array, seen: Activations) -> tuple[Self, Float32Array]:
        """Gradients by the weights and by the features (P, F), from those by the offsets (P, OFFSETS)."""
        features, trunk, hidden = seen
        by_output = [_across(hidden[:, own], by_offsets[:, part]) for own, part in _pairs()]
        by_hidden = np.concatenate(
            [row_products(by_offsets[:, part], self.output_weight[:, part].T) for part in PARTS], axis=1
        )
        by_hidden *= hidden > 0
        by_trunk = row_products(by_hidden, self.hidden_weight.T)
        by_trunk *= trunk > 0
        gradients = type(self)(
            trunk_weight=_across(features, by_trunk),
            trunk_bias=by_trunk.sum(axis=0),
            hidden_weight=_across(trunk, by_hidden),
            hidden_bias=by_hidden.sum(axis=0),
            output_weight=np.concatenate(by_output, axis=1),
            output_bias=by_offsets.sum(axis=0),
        )
        return gradients, row_products(by_trunk, self.trunk_weight.T)

    def arrays(self) -> dict[str, Float32Array]:
        """By field name, in a fixed order."""
        return {item.name: getattr(self, item.name) for item in fields(self)}


def _pairs() -> list[tuple[slice, slice]]:
    """For each head, its columns of the hidden layer and of the offsets."""
    return [(slice(head * WIDTH, (head + 1) * WIDTH), part) for head, part in enumerate(PARTS)]


def _rectified(values: Float32Array) -> Float32Array:
    return np.maximum(values, 0, out=values)


def _blocks(rows: Float32Array) -> Float32Array:
    return rows.reshape(-1, ROWS, rows.shape[1])


def _across(left: Float32Array, right: Float32Array) -> Float32Array:
    """left^T right, summed block by block."""
    total: NDArray[np.float32] = (_blocks(left).transpose(0, 2, 1) @ _blocks(right)).sum(axis=0)
    return total
