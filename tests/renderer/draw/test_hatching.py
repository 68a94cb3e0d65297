"""Lines over the background, where nothing was observed."""

from __future__ import annotations

import moderngl
import numpy as np
import pytest

from renderer.draw.offscreen import read_image
from renderer.draw.splat_view import SplatView
from renderer.unobserved import GREY, LINES, line_mask
from tests.renderer.scenes import random_splats, turned_camera

pytestmark = pytest.mark.gl


def test_hatching_lies_behind_the_splats_and_begins_in_the_upper_left(ctx: moderngl.Context) -> None:
    camera = turned_camera(94, 71)
    view, framebuffer = SplatView(ctx, precision="float"), ctx.simple_framebuffer((94, 71), 4, dtype="f4")
    view.upload(random_splats(300, camera, 5))
    sums = view.read_color(camera)
    view.draw(camera, framebuffer, background=GREY, lines=LINES)
    behind = np.where(line_mask(71, 94)[..., None], LINES, GREY)
    np.testing.assert_allclose(
        read_image(framebuffer), sums[..., :3] + (1 - sums[..., 3:]) * behind, atol=1e-5
    )
    view.release()
    framebuffer.release()
