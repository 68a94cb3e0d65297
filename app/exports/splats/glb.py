"""Splats as glTF by its extension KHR_gaussian_splatting, as Khronos has ratified it: points with attributes,
which programs without the extension show as points."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.errors import UserError
from app.exports.gltf import METRES, VERTICES, Buffer, asset, linear, packed
from renderer.glb import SPLATS as EXTENSION
from renderer.raw_gaussians import RawGaussians
from renderer.rotations import unit_quats
from renderer.splat_files.splat_file import PER_COLOR
from renderer.splat_files.y_up import y_up
from renderer.splats import Float32Array, RenderMode

POINTS: Final = 0
SRGB: Final = "srgb_rec709_display"
"""Colours are blended as they are displayed, as in training."""


def splats_glb(raw: RawGaussians, mode: RenderMode, unit: str, name: str, facts: Mapping[str, Any]) -> bytes:
    """The file; `facts`: provenance. The extension has no word for `mode`: it is in the extras of the asset.

    Raises:
        UserError: there is no splat, which glTF cannot say.
    """
    if not len(raw):
        raise UserError(f"expected a Gaussian at least, got none in {name}")
    turned, buffer = y_up(raw), Buffer()
    splats, scale = turned.splats(), np.float32(METRES.get(unit, 1.0))
    attributes = {
        "POSITION": buffer.array(splats.means * scale, VERTICES, bounded=True),
        "COLOR_0": buffer.array(_as_points(splats.colors, splats.opacities), VERTICES),
    }
    values = {
        "ROTATION": unit_quats(splats.quats)[:, [1, 2, 3, 0]],
        "SCALE": splats.scales * scale,
        "OPACITY": splats.opacities,
        "SH_DEGREE_0_COEF_0": (splats.colors - np.float32(0.5)) / np.float32(PER_COLOR),
    } | _harmonics(splats.harmonics)
    attributes |= {f"{EXTENSION}:{each}": buffer.array(value, VERTICES) for each, value in values.items()}
    primitive = {
        "mode": POINTS,
        "attributes": attributes,
        "extensions": {EXTENSION: {"kernel": "ellipse", "colorSpace": SRGB}},
    }
    document = {
        "asset": asset(unit, facts, render_mode=mode),
        "extensionsUsed": [EXTENSION],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": name, "mesh": 0}],
        "meshes": [{"name": name, "primitives": [primitive]}],
    }
    return packed(document, buffer)


def _as_points(colors: Float32Array, opacities: Float32Array) -> NDArray[np.uint8]:
    """(N, 4) what programs without the extension show."""
    values = np.concatenate([linear(colors.clip(0, 1)), opacities[:, None]], axis=1)
    return np.asarray(np.rint(255 * values), np.uint8)


def _harmonics(harmonics: Float32Array) -> dict[str, Float32Array]:
    """Of degree 1 and above, l = 1, 2, 3 with 2 l + 1 functions in each."""
    return {
        f"SH_DEGREE_{degree}_COEF_{place}": harmonics[:, degree**2 - 1 + place]
        for degree in (1, 2, 3)
        if harmonics.shape[1] >= (degree + 1) ** 2 - 1
        for place in range(2 * degree + 1)
    }
