"""Spherical harmonics: colours from the poles, from on top of a Gaussian and from very near and far."""

from __future__ import annotations

from collections.abc import Iterator
from math import factorial

import numpy as np
from numpy.typing import NDArray

from renderer.harmonics import harmonics_backward, seen_colors
from renderer.stability.row import Row

FloatArray = NDArray[np.float64]
HAZARD = "spherical harmonics"


def rows() -> Iterator[Row]:
    """Every function of degree 1 to 3, with coefficient 1, against float64 from the definition."""
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
        exact_units = means / np.linalg.norm(means.astype(np.float64), axis=1, keepdims=True)
        worst = float(np.abs(_values(means) - definition(exact_units)).max())
        yield Row(HAZARD, name, worst, 2e-6, "of 1")
        yield Row(HAZARD, f"{name}: gradients", _broken(means), 0, "broken values")
    here = np.zeros((1, 3), np.float32)
    yield Row(HAZARD, "seen from its own centre", float(np.abs(_values(here)).max()), 0, "of 1",
              "no direction: the part that depends on it is 0")  # fmt: skip
    yield Row(HAZARD, "seen from its own centre: gradients", _broken(here), 0, "broken values")


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


def _values(means: NDArray[np.float32]) -> FloatArray:
    """(N, 15), each function alone."""
    columns = []
    for function in range(15):
        harmonics = np.zeros((len(means), 15, 3), np.float32)
        harmonics[:, function] = 1
        columns.append(seen_colors(means, harmonics, np.zeros_like(means), np.zeros(3))[:, 0])
    return np.stack(columns, axis=1).astype(np.float64)


def _broken(means: NDArray[np.float32]) -> float:
    """How many gradients are no numbers."""
    count = len(means)
    harmonics, by_means = np.ones((count, 15, 3), np.float32), np.zeros((count, 3), np.float32)
    by_harmonics, by_colors = np.empty_like(harmonics), np.ones((count, 3), np.float32)
    seen = np.ones(count, bool)
    harmonics_backward(means, harmonics, np.zeros(3), seen, by_colors, by_harmonics, by_means)
    return float(np.count_nonzero(~np.isfinite(by_means)) + np.count_nonzero(~np.isfinite(by_harmonics)))
