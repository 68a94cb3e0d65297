"""The phantom's moving tissue: a smooth surface over material coordinates, hit exactly by rays."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from renderer.camera import FloatArray

DISTANCE = 60.0
"""Mean distance of the tissue from the first camera, mm."""

_ITERATIONS = 12
_CONVERGED = 1e-9  # mm


@dataclass(frozen=True, eq=False)
class Surface:
    """Points P(u, v, t) = (u, v, plane) + sum of Gaussian bumps times their weights at time t.

    u and v in mm name a point of the tissue for good; whatever is painted there moves with it.
    """

    tilt: FloatArray
    """(2,) slope of the plane along u and v."""
    centres: FloatArray
    """(K, 2) in mm."""
    sigmas: FloatArray
    """(K,) in mm."""
    amplitudes: FloatArray
    """(K, 3) displacement at the centre along x, y, z in mm."""
    cycles: FloatArray
    """(K,) breaths a clip; 0 = a bump of the rest shape; -1 = the pull."""

    @property
    def pull(self) -> FloatArray:
        """(2,) the material point that the tool pulls at."""
        return np.asarray(self.centres[-1])

    def weights(self, time: float) -> FloatArray:
        """(K,) at `time` in [0, 1]: 1 for the rest shape, a sine for breathing, one slow pull."""
        breathing = np.sin(2 * math.pi * self.cycles * time)
        pulling = math.sin(math.pi * time) ** 2
        return np.where(self.cycles == 0, 1.0, np.where(self.cycles < 0, pulling, breathing))

    def evaluate(
        self, u: FloatArray, v: FloatArray, time: float
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """World position and its derivatives along u and v, each (N, 3), for (N,) coordinates."""
        ones, none = np.ones_like(u), np.zeros_like(u)
        # Axis by axis: most bumps rise along z alone.
        position = np.stack([u, v, DISTANCE + self.tilt[0] * u + self.tilt[1] * v])
        along_u = np.stack([ones, none, self.tilt[0] * ones])
        along_v = np.stack([none, ones, self.tilt[1] * ones])
        rows = zip(self.centres, self.sigmas, self.weights(time)[:, None] * self.amplitudes, strict=True)
        for centre, sigma, amplitude in rows:
            if not amplitude.any():
                continue
            a, b = u - centre[0], v - centre[1]
            bump = np.exp((a * a + b * b) * (-0.5 / sigma**2))
            a, b = bump * a, bump * b
            for axis in np.flatnonzero(amplitude):
                position[axis] += bump * amplitude[axis]
                along_u[axis] += a * (amplitude[axis] / -(sigma**2))
                along_v[axis] += b * (amplitude[axis] / -(sigma**2))
        return position.T, along_u.T, along_v.T

    def hit(self, origin: FloatArray, directions: FloatArray, time: float) -> tuple[FloatArray, FloatArray]:
        """Material coordinates (N,), (N,) where rays from `origin` (3,) along `directions` (N, 3) meet it.

        Newton's method on the two coordinates, to 1e-9 mm. Slopes are gentle enough for one
        meeting point a ray.
        """
        slope = directions[:, :2] / directions[:, 2:]
        u, v = (origin[:2] + slope * (DISTANCE - origin[2])).T
        for _ in range(_ITERATIONS):
            position, along_u, along_v = self.evaluate(u, v, time)
            offset = position - origin
            gap = offset[:, :2] - slope * offset[:, 2:]
            if np.abs(gap).max() < _CONVERGED:
                return u, v
            gu, gv = (along[:, :2] - slope * along[:, 2:] for along in (along_u, along_v))
            determinant = gu[:, 0] * gv[:, 1] - gu[:, 1] * gv[:, 0]
            u = u - (gap[:, 0] * gv[:, 1] - gap[:, 1] * gv[:, 0]) / determinant
            v = v - (gap[:, 1] * gu[:, 0] - gap[:, 0] * gu[:, 1]) / determinant
        raise ArithmeticError(f"rays do not meet the surface within {_ITERATIONS} Newton steps")


def grow_surface(rng: np.random.Generator, moving: bool, cycles: int) -> Surface:
    """A random rest shape with breathing (up to 5 mm) and one local pull (9 mm), or none of them."""
    folds = 7
    angles = np.linspace(0, 2 * math.pi, folds, endpoint=False) + rng.uniform(0, 1, folds)
    radii = rng.uniform(12, 40, folds)
    centres = np.stack([radii * np.cos(angles), 0.8 * radii * np.sin(angles)], axis=1)
    sigmas = rng.uniform(9, 16, folds)
    heights = rng.choice([-1.0, 1.0], folds) * rng.uniform(0.35, 0.6, folds) * sigmas
    rest = np.stack([np.zeros(folds), np.zeros(folds), heights], axis=1)
    breath_centres = np.array([[-20.0, 15.0], [25.0, -20.0]]) + rng.uniform(-5, 5, (2, 2))
    breaths = np.array([[1.0, 1.5, -4.5], [-0.8, 0.6, 2.5]])
    pull = rng.uniform(-6, 6, (1, 2))
    moves = np.concatenate([breaths, [[5.0, 2.0, -7.0]]]) * moving
    return Surface(
        tilt=rng.uniform(-0.12, 0.12, 2) + np.array([0.0, -0.12]),
        centres=np.concatenate([centres, breath_centres, pull]),
        sigmas=np.concatenate([sigmas, [32.0, 28.0, 13.0]]),
        amplitudes=np.concatenate([rest, moves]),
        cycles=np.array([0.0] * folds + [cycles, cycles, -1.0]),
    )
