"""Eqs 13-15: where a Gaussian lies on the picture and how it spreads there, against 50 decimal digits."""

from __future__ import annotations

from collections.abc import Iterator
from decimal import Decimal, localcontext
from typing import Final

import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.measuring.stability.row import Row, worst
from renderer.measuring.stability.scenes import NEAR, SCENES, camera_of
from renderer.projection import (
    ACROSS,
    CENTER_X,
    CENTER_Y,
    DEPTH,
    DOWN,
    RECORD_SIZE,
    SHEAR,
    camera_vector,
    project,
)
from renderer.splats import Splats

DIGITS: Final = 50
GUARD: Final = 0.15
"""Of the picture, on each side: where the Jacobian stops to follow the mean."""
Exact = Decimal


def rows() -> Iterator[Row]:
    """Centre and depth, and the inverse of the covariance, of the splats of every scene."""
    for name, make in SCENES.items():
        splats = make()
        camera = camera_of(name)
        records, visible = _projected(splats, camera)
        drawn = _drawn(splats, camera)
        # A splat that is drawn and should not be, or is not and should, is infinitely far off.
        centers, conics = [0.0 if np.array_equal(visible, drawn) else np.inf], []
        for row in np.flatnonzero(drawn)[:20]:
            u, v, z, conic = exact(splats, int(row), camera)
            across, shear, down = map(float, conic)
            got = records[row].astype(np.float64)
            centers.append(_apart(got[[CENTER_X, CENTER_Y]], (u, v), max(abs(float(u)), abs(float(v)), 1.0)))
            centers.append(_apart(got[[DEPTH]], (z,), float(z)))
            # Of the shear, the width over the height: what it is where all lies along one line.
            wide = float(np.hypot(np.sqrt(down / across), shear))
            for place, value, unit in ((ACROSS, across, across), (SHEAR, shear, wide), (DOWN, down, down)):
                conics.append(abs(got[place] - value) / abs(unit))
        yield Row("projection (13): centre and depth", name, worst(centers), 1e-6, "of itself")
        yield Row("covariance (14, 15): its inverse", name, worst(conics), 1e-6, "of itself")


def _drawn(splats: Splats, camera: Camera) -> NDArray[np.bool_]:
    """(N,) True: beyond the near plane and not fainter than the cut."""
    depths = [
        sum(
            Decimal(float(p)) * Decimal(float(m))
            for p, m in zip(camera.camera_from_world[2], mean, strict=True)
        )
        for mean in np.column_stack([splats.means, np.ones(len(splats))])
    ]
    beyond = np.array([depth > Decimal(NEAR) for depth in depths])
    return beyond & (splats.opacities.astype(np.float64) >= 1 / 255)


def _projected(splats: Splats, camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    count = len(splats)
    records, visible = np.zeros((count, RECORD_SIZE), np.float32), np.zeros(count, bool)
    project(
        splats.means, splats.quats, splats.scales, splats.opacities, splats.colors,
        camera_vector(camera, NEAR), False, records, visible,
    )  # fmt: skip
    return records, visible


def exact(splats: Splats, row: int, camera: Camera) -> tuple[Exact, Exact, Exact, tuple[Exact, Exact, Exact]]:
    """Centre u, v, depth z, and ACROSS, SHEAR and DOWN of the exponent of 2, of one splat."""
    with localcontext() as context:
        context.prec = DIGITS
        mean = [Decimal(float(one)) for one in splats.means[row]]
        turned = _rotation([Decimal(float(one)) for one in splats.quats[row]])
        scale = [Decimal(float(one)) for one in splats.scales[row]]
        pose = [[Decimal(float(one)) for one in line] for line in camera.camera_from_world[:3]]
        x, y, z = (sum((p * m for p, m in zip(line[:3], mean, strict=True)), line[3]) for line in pose)
        across = _held(x / z, camera.cx, camera.fx, camera.width)
        down = _held(y / z, camera.cy, camera.fy, camera.height)
        axes = []
        for focal, line, slope in ((camera.fx, 0, across), (camera.fy, 1, down)):
            factor = [Decimal(focal) / z * (pose[line][k] - slope * pose[2][k]) for k in range(3)]
            axes.append([sum(factor[k] * turned[k][j] for k in range(3)) * scale[j] for j in range(3)])
        first, second = axes
        low_pass = Decimal("0.3")
        xx = sum((one * one for one in first), low_pass)
        yy = sum((one * one for one in second), low_pass)
        xy = sum((a * b for a, b in zip(first, second, strict=True)), Decimal(0))
        half = 1 / Decimal(2).ln() / 2
        u = Decimal(camera.fx) * x / z + Decimal(camera.cx)
        v = Decimal(camera.fy) * y / z + Decimal(camera.cy)
        return u, v, z, (-half * yy / (xx * yy - xy * xy), -xy / yy, -half / yy)


def _rotation(quat: list[Exact]) -> list[list[Exact]]:
    length = sum((one * one for one in quat), Decimal(0)).sqrt()
    w, x, y, z = (one / length for one in quat) if length else (Decimal(one) for one in (1, 0, 0, 0))
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]


def _held(slope: Exact, center: float, focal: float, size: int) -> Exact:
    margin = GUARD * size / focal
    return min(max(slope, Decimal(-center / focal - margin)), Decimal((size - center) / focal + margin))


def _apart(got: np.ndarray, exact_values: tuple[Exact, ...], unit: float) -> float:
    wanted = np.array([float(one) for one in exact_values])
    return float(np.abs(got - wanted).max() / unit)
