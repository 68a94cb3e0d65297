"""Curves of nodes fitted to shifts: equal to the whole matrix solved at once, and true where they can be."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from renderer.deformation.spline import spline_taps
from renderer.train.curve_fit import NEIGHBOURS, RIDGE, STEADY, CurveFit, Seen

GRID, CONTROLS = (3, 2), 6
NODES = GRID[0] * GRID[1]
TIMES = [index / 14 for index in range(14)]


def basis() -> NDArray[np.float64]:
    """(frames, controls)"""
    out = np.zeros((len(TIMES), CONTROLS))
    for row, time in zip(out, TIMES, strict=True):
        first, weights = spline_taps(time, CONTROLS)
        row[first : first + 4] = weights
    return out


def seen_of(curves: NDArray[np.float64], weights: Any) -> tuple[Seen, ...]:
    """From curves (frames, M, 3), as two references see them."""
    spans = ((2, slice(0, 9)), (10, slice(4, 14)))
    return tuple(
        Seen(at, span, curves[span] - curves[at], np.asarray(weights(span.stop - span.start)))
        for at, span in spans
    )


def exactly(seen: tuple[Seen, ...]) -> NDArray[np.float64]:
    """(M, K, 3): rows of one equation each, float64, solved by numpy."""
    taps, rows, values = basis(), [], []

    def add(coefficients: dict[int, NDArray[np.float64]], weight: float, value: NDArray[np.float64]) -> None:
        row = np.zeros((NODES, CONTROLS))
        for node, each in coefficients.items():
            row[node] = each
        rows.append(np.sqrt(weight) * row.reshape(-1))
        values.append(np.sqrt(weight) * value)

    none = np.zeros(3)
    for one in seen:
        for place, frame in enumerate(range(*one.frames.indices(len(TIMES)))):
            for node in range(NODES):
                add(
                    {node: taps[frame] - taps[one.reference]},
                    one.weights[place, node],
                    one.shifts[place, node],
                )
    for node in range(NODES):
        add({node: taps.mean(axis=0)}, 1.0, none)
        for k in range(CONTROLS):
            add({node: np.eye(CONTROLS)[k]}, RIDGE, none)
        for k in range(CONTROLS - 2):
            add({node: np.diff(np.eye(CONTROLS), n=2, axis=0)[k]}, STEADY, none)
        beside = [node + 1] if (node + 1) % GRID[0] else []
        for other in beside + [node + GRID[0]] * (node + GRID[0] < NODES):
            for k in range(CONTROLS):
                add({node: np.eye(CONTROLS)[k], other: -np.eye(CONTROLS)[k]}, NEIGHBOURS, none)
    found = np.linalg.lstsq(np.array(rows), np.array(values), rcond=None)[0]
    return np.asarray(found.reshape(NODES, CONTROLS, 3))


def fitted(seen: tuple[Seen, ...]) -> NDArray[np.float64]:
    """(M, K, 3)"""
    return CurveFit.of(TIMES, CONTROLS, GRID, seen).solved().transpose(1, 0, 2)


@pytest.mark.parametrize("seed", range(3))
def test_the_fit_is_the_least_squares_solution(seed: int) -> None:
    rng = np.random.default_rng(seed)
    curves = rng.normal(size=(len(TIMES), NODES, 3))
    seen = seen_of(
        curves, lambda count: rng.uniform(0, 1, (count, NODES)) * (rng.random((count, NODES)) > 0.3)
    )
    assert np.allclose(fitted(seen), exactly(seen), atol=2e-4)


def test_a_sway_of_the_whole_is_found_about_its_mean() -> None:
    sway = np.sin(np.pi * np.array(TIMES))[:, None, None] * np.array([3.0, 0.0, -1.0])
    curves = np.broadcast_to(sway, (len(TIMES), NODES, 3))
    seen = seen_of(curves, lambda count: np.ones((count, NODES)))
    found = np.einsum("fk,mkc->fmc", basis(), fitted(seen))
    assert np.abs(found - (curves - curves.mean(axis=0))).max() < 0.2


def test_nodes_that_nothing_was_seen_of_go_with_their_neighbours() -> None:
    sway = np.sin(np.pi * np.array(TIMES))[:, None, None] * np.array([3.0, 0.0, -1.0])
    blind = np.ones(NODES)
    blind[2] = 0
    seen = seen_of(np.broadcast_to(sway, (len(TIMES), NODES, 3)), lambda count: np.tile(blind, (count, 1)))
    found = fitted(seen)
    assert np.abs(found[2] - found[1]).max() < 0.1 * np.ptp(found[1])


def test_nothing_seen_rests() -> None:
    assert not fitted(()).any()
    nothing = seen_of(np.ones((len(TIMES), NODES, 3)), lambda count: np.zeros((count, NODES)))
    assert not fitted(nothing).any()
