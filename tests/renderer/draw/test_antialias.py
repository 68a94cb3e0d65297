"""Render mode "mip": what makes up for the low-pass filter, on the processor and with OpenGL."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import moderngl
import numpy as np
import pytest

from renderer.camera import Camera
from renderer.draw.offscreen import render_offscreen
from renderer.projection import LOG2_OPACITY
from renderer.rasterize.cpu import Rasterizer, render
from renderer.splats import RenderMode, Splats
from tests.renderer.draw.oracle import FloatImage, levels, psnr, reference
from tests.renderer.scenes import random_splats, turned_camera

CAMERA = turned_camera(96, 72)
BACKGROUND = (0.2, 0.35, 0.5)
Draw = Callable[[Splats, Camera, RenderMode], FloatImage]


@pytest.fixture(params=["processor", pytest.param("opengl", marks=pytest.mark.gl)])
def draw(request: pytest.FixtureRequest) -> Draw:
    if request.param == "processor":
        return lambda splats, camera, mode: render(splats, camera, BACKGROUND, mode=mode).image
    ctx: moderngl.Context = request.getfixturevalue("ctx")
    return lambda splats, camera, mode: render_offscreen(ctx, splats, camera, BACKGROUND, mode=mode)


def needles(thinness: float) -> Splats:
    """Thin ones and flat ones, `thinness` times as long as wide, some of them seen end on."""
    splats = random_splats(200, CAMERA, 3, sigma=(3.0, 9.0))
    scales = splats.scales.copy()
    scales[:100, 1:] = scales[:100, :1] / np.float32(thinness)
    scales[100:, 2] = scales[100:, 0] / np.float32(thinness)
    quats = splats.quats.copy()
    quats[::10] = (0.5, 0.5, 0.5, 0.5)
    return replace(splats, scales=scales, quats=quats)


SCENES = {
    "narrower than a pixel": random_splats(600, CAMERA, 1, sigma=(0.2, 1.0)),
    "wider": random_splats(300, CAMERA, 2),
    "needles": needles(30.0),
    "hairs": needles(1e4),
}


@pytest.mark.parametrize("splats", SCENES.values(), ids=SCENES)
def test_the_picture_is_that_of_the_reference(draw: Draw, splats: Splats) -> None:
    oracle = reference(splats, CAMERA, BACKGROUND, mode="mip").image.numpy()
    picture = draw(splats, CAMERA, "mip")
    assert psnr(picture, oracle) >= 75
    assert levels(picture, oracle, 0.999) <= 1
    assert psnr(draw(splats, CAMERA, "default"), oracle) < 45


def test_light_goes_with_the_area_of_a_small_splat(draw: Draw) -> None:
    """Half as wide: a quarter of the light. By default it hardly changes, which is what aliases."""
    camera = Camera.from_fov(40, 33, 33)

    def light(sigma: float, mode: RenderMode) -> float:
        scale = np.full((1, 3), sigma * 5 / camera.fx, np.float32)
        one = np.ones((1, 3), np.float32)
        at, turn = np.array([[0, 0, 5]], np.float32), np.array([[1, 0, 0, 0]], np.float32)
        splat = Splats(at, turn, scale, np.full(1, 0.95, np.float32), one)
        return float((draw(splat, camera, mode) - np.array(BACKGROUND, np.float32)).sum())

    assert light(0.2, "mip") / light(0.1, "mip") == pytest.approx(4, rel=0.15)
    assert light(0.2, "default") / light(0.1, "default") < 1.2


@pytest.mark.parametrize(
    "scales", [(0.0, 0.0, 0.0), (1e-30, 1e-30, 1e-30), (1e8, 1e-8, 1e-8), (1e15, 1e15, 1e15)]
)
def test_extreme_scales_keep_a_share_of_their_opacity(scales: tuple[float, float, float]) -> None:
    splats = replace(random_splats(20, CAMERA, 5), scales=np.tile(np.float32(scales), (20, 1)))
    rasterizer = Rasterizer(CAMERA.width, CAMERA.height)
    rasterizer.forward(splats, CAMERA, mode="mip")
    drawn = rasterizer.visible
    kept = np.exp2(rasterizer.records[drawn, LOG2_OPACITY])
    assert (kept >= 0.999 / 255).all()
    assert (kept <= 1.000001 * splats.opacities[drawn]).all()
    if max(scales) > 1e10:
        assert drawn.any()
        np.testing.assert_allclose(kept, splats.opacities[drawn], rtol=1e-6)
    if max(scales) < 1e-20:
        assert not drawn.any()


@pytest.mark.gl
def test_unknown_ways_of_drawing_are_refused(ctx: moderngl.Context) -> None:
    splats, camera, other = random_splats(1, CAMERA, 0), CAMERA, "Mip"
    with pytest.raises(ValueError, match="mode must be default or mip, got 'Mip'"):
        render_offscreen(ctx, splats, camera, mode=other)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="precision must be byte, half, float or None, got 'Mip'"):
        render_offscreen(ctx, splats, camera, precision=other)  # type: ignore[arg-type]
