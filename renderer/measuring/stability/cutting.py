"""Splats that the sides of an image or a field cut off, against float64; and which ones frames show."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from renderer.camera import BoolArray, Camera, FloatArray
from renderer.deformation.motion import Still
from renderer.gaussians import DynamicGaussians
from renderer.in_view import IMAGE_SIDES, FieldInView, InView, outline_of
from renderer.measuring.stability.row import Row
from renderer.measuring.stability.scenes import (
    CAMERA,
    DIAGONAL,
    NEAR,
    TURNED,
    elsewhere,
    joined,
    ordinary,
    raw_of,
    splat,
)
from renderer.projection import LOW_PASS
from renderer.rasterize.cpu import render
from renderer.shown import BEHIND, looks
from renderer.splats import Float32Array, Splats

Scene = tuple[Splats, Camera, InView]
GREY: Final = 0.1
"""Grey levels: float32 loses some of a pixel's share."""
CUT: Final = 1.0
"""The same of many splats: a contribution at the cut of 1/255 falls to either side of it."""
LEAST: Final = 1e-20
"""Scene units a pixel: what grows by less lies on one side."""
WALL: Final = 10.3008
"""Depth of tissue that hides what lies behind; between two float16."""
STEP: Final = 1e-4
"""Of its depth, from one Gaussian behind it to the next."""


def _beside(degrees: float = 35.0) -> Camera:
    """Looks at the middle of what CAMERA sees at depth 10, from beside it."""
    angle, back = np.radians(degrees), np.eye(4)
    pose = np.eye(4)
    pose[0, [0, 2]], pose[2, [0, 2]] = (np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))
    back[2, 3] = -10.0
    ahead = np.eye(4)
    ahead[2, 3] = 11.0
    return CAMERA.moved(ahead @ pose @ back)


def _beside_turned() -> Camera:
    """The same of TURNED."""
    return CAMERA.moved(_beside().camera_from_world @ TURNED.camera_from_world)


def _in_a_side() -> Camera:
    """Its centre lies in the plane of the left side of CAMERA's image."""
    pose = np.eye(4)
    pose[:3, 3] = 2.0 * CAMERA.cx / CAMERA.fx, 0.0, -2.0
    return CAMERA.moved(pose)


def _octagon() -> FieldInView:
    turns = np.arange(8) * np.pi / 4 + 0.2
    return FieldInView(CAMERA, (20.0, 15.0) + 11.0 * np.stack([np.cos(turns), np.sin(turns)], axis=1))


def _one_pixel() -> FieldInView:
    kept = np.zeros((CAMERA.height, CAMERA.width), bool)
    kept[14, 21] = True
    outline = outline_of(kept)
    assert outline is not None
    return FieldInView(CAMERA, outline)


def _without_size() -> Splats:
    places = [(-1.2, -0.6), (0.3, 0.4), (2.6, 0.1), (4.4, 0.0)]
    return joined(*(splat((x, y, 10.0), scale=(0.0, 0.0, 0.0)) for x, y in places))


def _broken() -> Splats:
    splats = joined(ordinary(40), splat(), splat(), splat())
    splats.means[-3, 0] = splats.scales[-2, 1] = splats.quats[-1, 2] = np.nan
    return splats


def _far_away() -> Splats:
    far = splat((6e10, 2e10, 1e12), scale=(1.5e11, 1e11, 1e11), opacity=0.9)
    return joined(ordinary(20), far, splat((1e12, 0.0, 10.0), scale=(5, 5, 5)))


def _large() -> Splats:
    return joined(*(splat((x, 0.3, 10.0), scale=(5, 4, 3)) for x in (-14.0, -10.0, 10.0, 14.0)))


def _small() -> Splats:
    rng = np.random.default_rng(2)
    places = rng.normal(size=(30, 2)) * 0.4 + ((21.5 - CAMERA.cx) / 4, (14.5 - CAMERA.cy) / 4.2)
    return joined(*(splat((x, y, 10.0), scale=(0.2, 0.1, 0.15)) for x, y in places.tolist()))


SCENES: Final[dict[str, Callable[[], Scene]]] = {
    "ordinary, the sides of an image": lambda: (elsewhere(ordinary(100)), _beside_turned(), TURNED),
    "ordinary, a field of eight sides": lambda: (ordinary(100), _beside(), _octagon()),
    "a needle of 1e8 px": lambda: (splat(quat=DIAGONAL, scale=(2.5e7, 1e-6, 1e-6)), _beside(), _octagon()),
    "without size": lambda: (_without_size(), _beside(), _octagon()),
    "far beside the view": lambda: (_large(), _beside(), CAMERA),
    "1e12 away": lambda: (_far_away(), _beside(5.0), _octagon()),
    "values that are no numbers": lambda: (_broken(), _beside(), _octagon()),
    "the camera in the plane of a side": lambda: (ordinary(100), _in_a_side(), CAMERA),
    "a field of one pixel": lambda: (_small(), _beside(), _one_pixel()),
}
BARS: Final = {"ordinary, the sides of an image": CUT, "ordinary, a field of eight sides": CUT}


def rows() -> Iterator[Row]:
    """The largest error of each picture."""
    for name, make in SCENES.items():
        splats, camera, within = make()
        wanted = drawn(splats, camera, within)
        got = render(splats, camera, near=NEAR, within=within).image.astype(np.float64)
        apart = np.abs(got - wanted)
        yield Row("cut splats", name, 255 * float(apart.max()), BARS.get(name, GREY), "grey levels")


def drawn(splats: Splats, camera: Camera, within: InView) -> FloatArray:
    """(H, W, 3) over black, in float64: Eqs 13-16 of one splat after another, with the share of each pixel
    that lies within the sides, by the singular values of each splat's half axes on screen."""
    light, image = np.ones((camera.height, camera.width)), np.zeros((camera.height, camera.width, 3))
    pose = camera.camera_from_world
    depths = splats.means.astype(np.float64) @ pose[2, :3] + pose[2, 3]
    for i in np.argsort(depths, kind="stable"):
        numbers = (splats.means[i], splats.quats[i], splats.scales[i])
        if depths[i] > NEAR and all(np.isfinite(value).all() for value in numbers):
            shape = [value.astype(np.float64) for value in numbers]
            alpha = _alpha(shape[0], shape[1], shape[2], float(splats.opacities[i]), camera, within)
            weight = np.where(light >= 1e-4, alpha * light, 0.0)
            image += weight[..., None] * splats.colors[i]
            light -= weight
    return image


def _alpha(
    mean: FloatArray, quat: FloatArray, scale: FloatArray, opacity: float, camera: Camera, within: InView
) -> FloatArray:
    """(H, W)."""
    turn, pose = _turn(quat), camera.camera_from_world
    local = pose[:3, :3] @ mean + pose[:3, 3]
    lens, middle = np.array([camera.fx, camera.fy]), np.array([camera.cx, camera.cy])
    size = np.array([camera.width, camera.height])
    band = 0.15 * size / lens
    slope = np.clip(local[:2] / local[2], -middle / lens - band, (size - middle) / lens + band)
    half = pose[:3, :3] @ turn * scale
    axes = (lens / local[2])[:, None] * (half[:2] - slope[:, None] * half[2])
    ways, lengths, along = np.linalg.svd(axes, full_matrices=False)
    y, x = np.mgrid[: camera.height, : camera.width] + 0.5
    offsets = np.stack([x, y], axis=-1) - (lens * local[:2] / local[2] + middle)
    spread = lengths**2 + LOW_PASS
    alpha = np.minimum(0.99, opacity * np.exp(-0.5 * ((offsets @ ways) ** 2 / spread).sum(axis=-1)))
    share = np.ones_like(alpha)
    for normal, distance in _nearest(mean, within):
        growth = ways @ (lengths / spread * (along @ (scale * (turn.T @ normal))))
        apart = (distance + offsets @ growth) / max(float(np.linalg.norm(growth)), LEAST)
        share = np.minimum(share, np.clip(apart + 0.5, 0.0, 1.0))
    alpha = alpha * share
    return np.where(alpha >= 1 / 255, alpha, 0.0)


def _nearest(mean: FloatArray, within: InView) -> list[tuple[FloatArray, float]]:
    """Normals of the sides that count, and how far they are: of an image all, of a field two."""
    sides = [(side[:3], float(side[:3] @ mean + side[3])) for side in within.sides]
    return sides[:IMAGE_SIDES] + sorted(sides[IMAGE_SIDES:], key=lambda side: side[1])[:2]


def _turn(quat: FloatArray) -> FloatArray:
    """v + 2 w (u x v) + 2 u x (u x v) of each axis v."""
    w, *u = quat / np.linalg.norm(quat)
    once = np.cross(u, np.eye(3))
    turn: FloatArray = (np.eye(3) + 2 * w * once + 2 * np.cross(u, once)).T
    return turn


def shown() -> Iterator[Row]:
    """Gaussians behind tissue that fills the upper half of an image, and those with extreme values."""
    hazard = "Gaussians that frames show"
    depths = WALL * (1 + STEP * np.arange(1, 700))
    behind = joined(*(_speck((0.02 * z, -0.2 * z, z)) for z in depths.tolist()))
    found = _shown(behind)
    least = WALL / (1 - BEHIND)
    error = abs(float(depths[found].max(initial=0.0)) / least - 1)
    yield Row(hazard, "depth behind tissue to which they count", error, 2 * STEP, "of itself")
    told = [_shown(_speck(place, size))[0] != wanted for place, size, wanted in EXTREME]
    yield Row(hazard, "without size, a needle, 1e12 away, NaN: told otherwise", float(sum(told)), 0, "cases")


def _speck(place: tuple[float, float, float], size: float = 1e-3) -> Splats:
    return splat(place, scale=(size, 1e-3, 1e-3), opacity=0.01)


EXTREME: Final = (
    ((0.2, -2.0, 9.9), 1e-30, True),
    ((0.2, 2.0, 30.0), 1e-30, True),
    ((0.2, -2.0, 30.0), 1e-30, False),
    ((0.02, -0.1, -1.0), 1e-3, False),
    ((0.2, -2.0, NEAR / 2), 1e-3, False),
    ((2e10, 2e11, 1e12), 1e-3, True),
    ((2e10, -2e11, 1e12), 1e-3, False),
    ((1e12, 2.0, 10.0), 1e-3, False),
    ((40.0, 2.0, 10.0), 2.5e7, True),
    ((40.0, 2.0, 10.0), 1e-3, False),
    ((np.nan, 2.0, 10.0), 1e-3, False),
    ((0.2, 2.0, np.nan), 1e-3, False),
)
"""Place and length of each, and whether a frame shows it."""


def _shown(splats: Splats) -> BoolArray:
    """Of these, beside the tissue."""
    raw = raw_of(joined(_wall(), splats))
    *_, found = looks(DynamicGaussians(raw, Still()), (CAMERA,), NEAR, "default")
    tail: BoolArray = found[-len(splats) :]
    return tail


def _wall() -> Splats:
    """Overlapping discs, square to the view, above its middle."""
    x, y = (each.ravel() for each in np.meshgrid(np.linspace(-6, 6, 25), np.linspace(-6, -0.8, 12)))
    means: Float32Array = np.stack([x, y, np.full_like(x, WALL)], axis=1).astype(np.float32)
    disc = splat(scale=(0.5, 0.5, 1e-4), opacity=0.95)
    names = ("quats", "scales", "opacities", "colors")
    return replace(
        disc, means=means, **{name: getattr(disc, name).repeat(len(means), axis=0) for name in names}
    )
