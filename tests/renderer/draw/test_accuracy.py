from __future__ import annotations

import moderngl
import numpy as np
import pytest

from renderer.deformation.spline_motion import SplineMotion
from renderer.gaussians import DynamicGaussians
from renderer.measuring.drawing_accuracy import EXPORT, keyframes, opengl
from renderer.measuring.raster_accuracy import exact
from renderer.raw_gaussians import RawGaussians
from tests.renderer.scenes import random_splats, turned_camera

pytestmark = pytest.mark.gl
CAMERA = turned_camera(96, 72)


def test_the_export_setting_is_nearest_and_fewer_pixels_are_farther(ctx: moderngl.Context) -> None:
    splats = random_splats(300, CAMERA)
    rows = {
        row.setting: row for row in opengl(ctx, splats, CAMERA, 0.01, exact(splats, CAMERA, 0.01), repeats=1)
    }
    assert rows[EXPORT].mean == min(row.mean for row in rows.values())
    assert rows[EXPORT].p999 <= 1
    assert rows["half target, float32 keys"].mean > rows[EXPORT].mean
    sizes = [rows[f"float target, 1/{divisor} along each side"].mean for divisor in (2, 4)]
    assert rows[EXPORT].mean < sizes[0] < sizes[1]


def moving() -> DynamicGaussians:
    splats = random_splats(60, CAMERA)
    raw = RawGaussians(
        means=splats.means, quats=splats.quats, log_scales=np.log(splats.scales),
        opacity_logits=np.full(60, 2.0, np.float32), colors=splats.colors, harmonics=splats.harmonics,
    )  # fmt: skip
    controls = np.random.default_rng(0).normal(0, 4, (60, 9, 3)).astype(np.float32)
    none = np.zeros((0, 9, 3), np.float32)
    motion = SplineMotion(
        position_controls=controls, color_controls=none, opacity_controls=none[..., :1], node_controls=none,
        node_indices=np.zeros((0, 4), np.int32), node_weights=np.zeros((0, 4), np.float32),
    )  # fmt: skip
    return DynamicGaussians(raw, motion)


def test_fewer_keyframes_err_more_and_weigh_less(ctx: moderngl.Context) -> None:
    times = [index / 24 for index in range(24)]
    rows = list(keyframes(ctx, moving(), CAMERA, times, 0.01, pixel=1.0, repeats=1))
    assert rows[0].mean == 0
    by_count = rows[1:5]
    errors, sizes = [row.mean for row in by_count], [row.megabytes for row in by_count]
    assert errors == sorted(errors)
    assert errors[-1] > 2 * errors[0] > 0
    assert sizes == sorted(sizes, key=lambda size: -(size or 0))
    assert all(row.milliseconds > 0 for row in rows)
