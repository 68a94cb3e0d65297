"""Splats that are hard to draw, by name, before one small camera."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from renderer.camera import Camera
from renderer.raw_gaussians import RawGaussians
from renderer.splats import Splats

CAMERA: Final = Camera(40.0, 42.0, 19.3, 15.6, 40, 32)
TURNED: Final = CAMERA.moved(
    np.array([[0.6, 0.0, 0.8, 1.5], [0.48, 0.8, -0.36, -2.0], [-0.64, 0.6, 0.48, 3.0], [0, 0, 0, 1]])
)
"""Elsewhere: by rotation and translation."""
ELSEWHERE: Final = "ordinary, before a camera elsewhere"
NEAR: Final = 2.0**-7
"""A float32, so that a splat can lie on it."""
DIAGONAL: Final = (0.92388, 0.0, 0.0, 0.38268)
"""A turn of 45 degrees in the plane of the picture."""
TOWARDS: Final = (0.70711, 0.0, 0.70711, 0.0)
"""The first axis along the view."""
Vector = Sequence[float]


def splat(
    mean: Vector = (0.3, -0.2, 10.0),
    quat: Vector = (1.0, 0.0, 0.0, 0.0),
    scale: Vector = (1.0, 0.6, 0.8),
    opacity: float = 0.8,
    color: Vector = (0.9, 0.5, 0.2),
) -> Splats:
    """One."""
    return Splats(
        means=np.array([mean], np.float32),
        quats=np.array([quat], np.float32),
        scales=np.array([scale], np.float32),
        opacities=np.array([opacity], np.float32),
        colors=np.array([color], np.float32),
    )


def joined(*parts: Splats) -> Splats:
    """All in one."""
    names = ("means", "quats", "scales", "opacities", "colors")
    return Splats(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def ordinary(count: int = 200) -> Splats:
    """Over the whole view, at depths of 5 to 15, axes within 10:1."""
    rng = np.random.default_rng(0)
    depth = rng.uniform(5, 15, count)
    pixels = rng.uniform(0, 1, (count, 2)) * (CAMERA.width, CAMERA.height)
    ways = (pixels - (CAMERA.cx, CAMERA.cy)) / (CAMERA.fx, CAMERA.fy)
    sigma = rng.uniform(0.02, 0.1, (count, 1)) * 10 ** rng.uniform(-1, 0, (count, 3))
    return Splats(
        means=np.column_stack([ways * depth[:, None], depth]).astype(np.float32),
        quats=rng.normal(size=(count, 4)).astype(np.float32),
        scales=(sigma * depth[:, None]).astype(np.float32),
        opacities=rng.uniform(0.1, 0.95, count).astype(np.float32),
        colors=rng.uniform(0, 1, (count, 3)).astype(np.float32),
    )


def elsewhere(splats: Splats) -> Splats:
    """What TURNED sees about where CAMERA saw it."""
    pose = TURNED.world_from_camera
    means = splats.means @ pose[:3, :3].T + pose[:3, 3]
    return replace(splats, means=means.astype(np.float32))


def stacked(count: int, opacity: float, depths: tuple[float, float] = (5, 15)) -> Splats:
    """Behind each other on one ray, wider than the picture, in changing colours."""
    rng = np.random.default_rng(1)
    return Splats(
        means=np.column_stack([np.zeros((count, 2)), np.linspace(*depths, count)]).astype(np.float32),
        quats=np.tile(np.array([1, 0, 0, 0], np.float32), (count, 1)),
        scales=np.full((count, 3), 30.0, np.float32),
        opacities=np.full(count, opacity, np.float32),
        colors=rng.uniform(0, 1, (count, 3)).astype(np.float32),
    )


def at_depths(*depths: float) -> Splats:
    """As large on the picture at each depth."""
    return joined(
        *(
            splat(
                (0.03 * z, -0.02 * z, z),
                (1.0, 0.0, 0.0, 0.0),
                (0.1 * z, 0.06 * z, 0.08 * z),
                0.5,
                (c, 0.5, 1 - c),
            )
            for c, z in zip(np.linspace(0, 1, len(depths)).tolist(), depths, strict=True)
        )
    )


SCENES: Final[dict[str, Callable[[], Splats]]] = {
    "ordinary": ordinary,
    "anisotropy 1e6, a needle over the view": lambda: splat(quat=DIAGONAL, scale=(1e3, 1e-3, 1e-3)),
    "anisotropy 1e6, a needle within the view": lambda: splat(quat=DIAGONAL, scale=(2.0, 2e-6, 2e-6)),
    "anisotropy 1e6, a needle along the view": lambda: splat(quat=TOWARDS, scale=(2.0, 2e-6, 2e-6)),
    "anisotropy 1e6, a disc on edge": lambda: splat(quat=TOWARDS, scale=(2e-6, 2.0, 2.0)),
    "anisotropy 1e7, the most that training lets be": lambda: splat(quat=DIAGONAL, scale=(10, 1e-6, 1e-6)),
    "scales of 1e-8": lambda: splat(scale=(1e-8, 1e-8, 1e-8)),
    "scales of 1e8": lambda: splat(scale=(1e8, 1e8, 1e8)),
    "scales of 1e-8 and 1e8": lambda: splat(quat=DIAGONAL, scale=(1e8, 1e-8, 1e-8)),
    "q = 0": lambda: splat(quat=(0, 0, 0, 0)),
    "q of length 1e-18": lambda: splat(quat=(1e-18, 0, 0, 4e-19)),
    "q of length 1e18": lambda: splat(quat=(1e18, 0, 0, 4e17)),
    "z just beyond the near plane": lambda: at_depths(NEAR * (1 + 1e-6), 1.0),
    "z at the near plane and before it": lambda: at_depths(NEAR, NEAR / 2, 1.0),
    "z from 0.1 to 1e8": lambda: at_depths(0.1, 1.0, 1e3, 1e6, 1e8),
    "far beside the view": lambda: joined(ordinary(20), splat((1e4, 0, 10.0), scale=(5, 5, 5))),
    "opacity 0": lambda: joined(ordinary(20), splat(opacity=0.0)),
    "opacity 1": lambda: joined(splat(opacity=1.0), ordinary(50)),
    "opacity at the cut": lambda: joined(
        ordinary(20), splat(opacity=1.00001 / 255), splat(opacity=0.99999 / 255)
    ),
    "300 faint ones on one ray": lambda: stacked(300, 0.02),
    "300 opaque ones on one ray": lambda: stacked(300, 1.0),
    "300 faint ones within 1e-3 of a depth, the last in front": lambda: stacked(300, 0.02, (10.001, 10.0)),
    "colours of 1e3 and -1e3": lambda: joined(splat(color=(1e3, -1e3, 0)), ordinary(50)),
    ELSEWHERE: lambda: elsewhere(ordinary()),
}
"""Made when they are asked for."""


def camera_of(scene: str) -> Camera:
    """What sees it."""
    return TURNED if scene == ELSEWHERE else CAMERA


def raw_of(splats: Splats) -> RawGaussians:
    """The same, as training has them."""
    return RawGaussians(
        means=splats.means,
        quats=splats.quats,
        log_scales=np.log(splats.scales),
        opacity_logits=np.log(splats.opacities / (1 - splats.opacities)),
        colors=splats.colors,
        harmonics=splats.harmonics,
    )


def noisy_gradients(raw: RawGaussians, rng: np.random.Generator) -> RawGaussians:
    """Of about 1, by every raw value."""
    return RawGaussians(**{
        name: (1 + rng.normal(size=value.shape)).astype(np.float32) for name, value in raw.arrays().items()
    })  # fmt: skip
