"""Spherical harmonics: colours from the poles, from on top of a Gaussian and from very near and far."""

from __future__ import annotations

from collections.abc import Iterator
from math import factorial

import numpy as np
from numpy.typing import NDArray

from renderer.harmonics import harmonics_backward, seen_colors
from renderer.measuring.stability.row import Row, worst

FloatArray = NDArray[np.float64]
HAZARD = "spherical harmonics"
STEP = 1e-5
"""Of the differences that the slopes of the definition are, in distances."""


def rows() -> Iterator[Row]:
    """Every function of degree 1 to 3 and what follows from it, against float64 from the definition."""
    directions = np.random.default_rng(0).normal(size=(500, 3))
    axes = np.concatenate([np.eye(3), -np.eye(3), np.eye(3) + 1e-6])
    for name, ways, length in (
        ("500 directions", directions, 1.0),
        ("along the axes and beside them", axes, 1.0),
        ("at a distance of 1e-18", directions, 1e-18),
        ("at a distance of 1e18", directions, 1e18),
    ):
        units = ways / np.linalg.norm(ways, axis=1, keepdims=True)
        means = (length * units).astype(np.float32)
        error = float(np.abs(_values(means) - definition(_units(means))).max())
        yield Row(HAZARD, name, error, 2e-6, "of 1")
        by_means, by_harmonics = _slope_errors(means)
        yield Row(HAZARD, f"{name}: gradients by the means", by_means, 1e-5, "of the largest")
        yield Row(HAZARD, f"{name}: by the harmonics", by_harmonics, 2e-6, "of 1")
    here = np.zeros((1, 3), np.float32)
    done = "no direction: the part that depends on it is 0"
    yield Row(HAZARD, "seen from its own centre", float(np.abs(_values(here)).max()), 0, "of 1", done)
    size = worst(float(np.abs(each).max()) for each in _slopes(here)[:2])
    yield Row(HAZARD, "seen from its own centre: gradients", size, 0, "of 1", done)


def definition(directions: FloatArray) -> FloatArray:
    """(N, 3) unit vectors to the values (N, 15), by Rodrigues' formula with the Condon-Shortley phase."""
    x, y, z = directions.T
    azimuth = np.arctan2(y, x)
    columns = []
    for degree in range(1, 4):
        for order in range(-degree, degree + 1):
            k = abs(order)
            power = np.polynomial.Polynomial([-1, 0, 1]) ** degree / (2**degree * factorial(degree))
            legendre = (-1) ** k * np.hypot(x, y) ** k * power.deriv(degree + k)(z)
            norm = np.sqrt((2 * degree + 1) / (4 * np.pi) * factorial(degree - k) / factorial(degree + k))
            wave = np.cos(k * azimuth) if order >= 0 else np.sin(k * azimuth)
            columns.append((np.sqrt(2) if order else 1) * norm * legendre * wave)
    return np.stack(columns, axis=1)


def _units(means: NDArray[np.float32]) -> FloatArray:
    wide = means.astype(np.float64)
    return np.asarray(wide / np.linalg.norm(wide, axis=1, keepdims=True))


def _values(means: NDArray[np.float32]) -> FloatArray:
    """(N, 15), each function alone."""
    columns = []
    for function in range(15):
        harmonics = np.zeros((len(means), 15, 3), np.float32)
        harmonics[:, function] = 1
        columns.append(seen_colors(means, harmonics, np.zeros_like(means), np.zeros(3))[:, 0])
    return np.stack(columns, axis=1).astype(np.float64)


def _slope_errors(means: NDArray[np.float32]) -> tuple[float, float]:
    """Of the gradients by the means, times the distance; and by the coefficients."""
    by_means, by_harmonics, harmonics, by_colors = _slopes(means)
    units, weights = _units(means), np.einsum("nbc,nc->nb", harmonics.astype(np.float64), by_colors)
    exact = np.stack([_slope(units, axis, weights) for axis in range(3)], axis=1)
    distances = np.linalg.norm(means.astype(np.float64), axis=1, keepdims=True)
    apart = np.abs(by_means * distances - exact).max() / np.abs(exact).max()
    wanted = definition(units)[:, :, None] * by_colors[:, None, :]
    return float(apart), float(np.abs(by_harmonics - wanted).max() / np.abs(by_colors).max())


def _slope(units: FloatArray, axis: int, weights: FloatArray) -> FloatArray:
    """(N,) of the weighted functions along an axis, from central differences."""
    sides = []
    for step in (STEP, -STEP):
        moved = units.copy()
        moved[:, axis] += step
        sides.append((definition(moved / np.linalg.norm(moved, axis=1, keepdims=True)) * weights).sum(axis=1))
    return np.asarray((sides[0] - sides[1]) / (2 * STEP))


def _slopes(
    means: NDArray[np.float32],
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """Gradients by means and harmonics, the harmonics, and the gradients by the colours."""
    count, rng = len(means), np.random.default_rng(3)
    harmonics = rng.normal(size=(count, 15, 3)).astype(np.float32)
    by_colors = rng.normal(size=(count, 3)).astype(np.float32)
    by_harmonics, by_means = np.empty_like(harmonics), np.zeros((count, 3), np.float32)
    seen = np.ones(count, bool)
    harmonics_backward(means, harmonics, np.zeros(3), seen, by_colors, by_harmonics, by_means)
    return by_means, by_harmonics, harmonics, by_colors
