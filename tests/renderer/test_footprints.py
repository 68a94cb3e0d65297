"""Footprints of splats against what each covers when it is drawn alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from renderer.camera import Camera
from renderer.projection import CENTER_X, CENTER_Y, HALF_HEIGHT, HALF_WIDTH
from renderer.rasterize.cpu import Rasterizer
from renderer.rasterize.footprints import footprints
from renderer.splats import Splats

WIDTH, HEIGHT, COUNT = 96, 64, 40
CAMERA = Camera(80.0, 80.0, WIDTH / 2, HEIGHT / 2, WIDTH, HEIGHT)


def splats() -> Splats:
    """All over the image and its border, of all shapes, none of them small against a pixel."""
    rng = np.random.default_rng(0)
    places = rng.uniform((-7, -5, 10), (7, 5, 12), (COUNT, 3))
    return Splats(
        means=places.astype(np.float32),
        quats=rng.normal(size=(COUNT, 4)).astype(np.float32),
        scales=np.exp(rng.uniform(-1.5, 0.2, (COUNT, 3))).astype(np.float32),
        opacities=rng.uniform(0.02, 0.98, COUNT).astype(np.float32),
        colors=np.full((COUNT, 3), 0.5, np.float32),
        harmonics=np.zeros((COUNT, 0, 3), np.float32),
    )


def alone(every: Splats, n: int) -> float:
    one = replace(every, **{name: value[n : n + 1] for name, value in vars(every).items()})
    rasterizer = Rasterizer(WIDTH, HEIGHT)
    rasterizer.forward(one, CAMERA, 0.1)
    return float(rasterizer.blending_weights(np.ones((HEIGHT, WIDTH), bool))[0, 0])


def test_a_footprint_is_what_a_splat_covers_alone_in_front_of_others_or_behind() -> None:
    every, rasterizer = splats(), Rasterizer(WIDTH, HEIGHT)
    rasterizer.forward(every, CAMERA, 0.1)
    assert rasterizer.visible.all()
    drawn = np.array([alone(every, n) for n in range(COUNT)])
    covered = footprints(rasterizer.records, WIDTH, HEIGHT)
    within = rasterizer.blending_weights(np.ones((HEIGHT, WIDTH), bool))[0]
    assert np.count_nonzero(within < 0.7 * drawn) > 5
    assert np.count_nonzero(drawn < 0.9 * footprints(rasterizer.records, 10**6, 10**6)) > 5
    half = rasterizer.records[:, [HALF_WIDTH, HALF_HEIGHT]]
    center = rasterizer.records[:, [CENTER_X, CENTER_Y]]
    corner = ((center < half) | (center + half > (WIDTH, HEIGHT))).all(axis=1)
    assert 0 < corner.sum() < COUNT / 2
    np.testing.assert_allclose(covered[~corner], drawn[~corner], rtol=0.05, atol=1)
    np.testing.assert_allclose(covered[corner], drawn[corner], rtol=0.3)
