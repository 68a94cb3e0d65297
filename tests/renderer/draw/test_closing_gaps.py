"""OpenGL closes small gaps as the CPU does."""

from __future__ import annotations

import moderngl
import numpy as np
import pytest

from renderer.closing import closed
from renderer.draw.offscreen import read_image
from renderer.draw.splat_view import Precision, SplatView
from renderer.rasterize.cpu import render
from renderer.unobserved import GREY
from tests.renderer.scenes import random_splats, turned_camera

pytestmark = pytest.mark.gl


@pytest.mark.parametrize(("precision", "most"), [("float", 2e-4), ("half", 8e-3)])
@pytest.mark.parametrize("closing", [0, 1, 4, 100])
def test_it_is_what_the_processor_draws(
    ctx: moderngl.Context, precision: Precision, most: float, closing: int
) -> None:
    camera = turned_camera(94, 71)
    splats = random_splats(300, camera, 5)
    view, framebuffer = SplatView(ctx, precision=precision), ctx.simple_framebuffer((94, 71), 4, dtype="f4")
    view.upload(splats)
    view.draw(camera, framebuffer, background=GREY, closing=closing)
    drawn = closed(render(splats, camera), closing)
    expected = drawn.image + (1 - drawn.alpha[..., None]) * np.float32(GREY)
    found = read_image(framebuffer)
    assert np.abs(found - expected).max() < most
    if closing:
        view.draw(camera, framebuffer, background=GREY)
        assert np.abs(read_image(framebuffer) - found).max() > 0.02
    view.release()
    framebuffer.release()
