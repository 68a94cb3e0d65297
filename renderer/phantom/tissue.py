"""Paints the phantom's tissue: colour, vessels and fine relief over material coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from renderer.camera import FloatArray
from renderer.phantom.vessels import Vessel, grow_vessels
from renderer.splats import Float32Array

REACH = 64.0
"""Half the painted width, mm."""
_TEXELS = 2048
_PER_MM = _TEXELS / (2 * REACH)
_SHIFT = 4  # Fractional bits of OpenCV's drawing coordinates.

_PINK = (0.90, 0.58, 0.53)
_RED = (0.80, 0.40, 0.35)
_FAT = (0.93, 0.70, 0.46)
_ARTERY = (0.35, 1.9, 1.8)
"""Absorbance of a wide artery for R, G, B: blood takes green and blue."""
_VEIN = (1.3, 1.75, 1.15)
"""Absorbance of a wide vein: dark, less blue taken."""


@dataclass(frozen=True, eq=False)
class Tissue:
    """Textures (S, S[, channels]) over [-REACH, REACH] mm in u (columns) and v (rows)."""

    albedo: Float32Array
    """(S, S, 3) linear RGB in [0, 1]."""
    vessels: Float32Array
    """(S, S) coverage in [0, 1]."""
    relief: Float32Array
    """(S, S, 2) slopes of the wet surface along u and v."""

    def blurred(self, sigma: float) -> Tissue:
        """Colour and relief smoothed by `sigma` mm: what one pixel gathers. Vessel truth stays sharp."""
        texels = sigma * _PER_MM
        if texels < 0.3:
            return self
        albedo = np.asarray(cv2.GaussianBlur(self.albedo, (0, 0), texels), dtype=np.float32)
        relief = np.asarray(cv2.GaussianBlur(self.relief, (0, 0), texels), dtype=np.float32)
        return Tissue(albedo, self.vessels, relief)


def sample(texture: Float32Array, u: FloatArray, v: FloatArray) -> Float32Array:
    """Bilinear values of a texture at material coordinates (H, W) in mm; mirrored beyond its edge."""
    columns = ((u + REACH) * _PER_MM - 0.5).astype(np.float32)
    rows = ((v + REACH) * _PER_MM - 0.5).astype(np.float32)
    values = cv2.remap(texture, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT_101)
    return np.asarray(values, dtype=np.float32)


def paint_tissue(rng: np.random.Generator) -> Tissue:
    """Pink tissue with redder mottling, patches of fat, veins below arteries, and a wet relief."""
    mottle = _noise(rng, (6.0, 2.5, 1.5), (1.0, 0.7, 0.4))
    fat = _smoothstep(_noise(rng, (22.0, 8.0), (1.0, 0.35)), 0.1, 1.5)
    colour = _mix(
        _mix(_filled(_PINK), _filled(_RED), _smoothstep(mottle, -1.0, 2.2)), _filled(_FAT), 0.8 * fat
    )
    albedo = colour**2.2 * np.exp(0.05 * _noise(rng, (2.0,), (1.0,)))[:, :, None]
    grown = grow_vessels(rng, REACH * 0.95)
    veins, arteries = ([vessel for vessel in grown if vessel.vein == kind] for kind in (True, False))
    # Veins lie deeper: scattering above them blurs their edges and lightens them.
    for vessels, absorbance, blur, strength in ((veins, _VEIN, 0.22, 0.8), (arteries, _ARTERY, 0.06, 1.0)):
        thickness = strength * _smooth(_draw(vessels, by_radius=True), blur)
        albedo = albedo * np.exp(-thickness[:, :, None] * np.array(absorbance, dtype=np.float32))
    bumps = _noise(rng, (4.0, 1.6, 0.7), (0.5, 0.10, 0.02))
    slopes = np.stack([np.gradient(bumps, axis=1), np.gradient(bumps, axis=0)], axis=2) * _PER_MM
    coverage = _draw(grown, by_radius=False)
    return Tissue(np.clip(albedo, 0, 1).astype(np.float32), coverage, slopes.astype(np.float32))


def _draw(vessels: list[Vessel], by_radius: bool) -> Float32Array:
    """(S, S) vessels in [0, 1], anti-aliased; `by_radius` draws thin ones fainter: they hold less blood."""
    layer = np.zeros((_TEXELS, _TEXELS), dtype=np.uint8)
    for vessel in sorted(vessels, key=lambda vessel: vessel.radius):
        level = round(255 * min(1.0, 0.4 + 0.9 * vessel.radius)) if by_radius else 255
        points = ((vessel.path + REACH) * _PER_MM - 0.5) * (1 << _SHIFT)
        width = max(1, round(2 * vessel.radius * _PER_MM))
        line = np.rint(points).astype(np.int32).reshape(-1, 1, 2)
        cv2.polylines(layer, [line], False, level, width, cv2.LINE_AA, _SHIFT)
    return layer.astype(np.float32) / np.float32(255)


def _noise(rng: np.random.Generator, grains: tuple[float, ...], weights: tuple[float, ...]) -> Float32Array:
    """(S, S) sum of smooth random fields with grains of the given sizes in mm, each about `weight` strong."""
    total = np.zeros((_TEXELS, _TEXELS), dtype=np.float32)
    for grain, weight in zip(grains, weights, strict=True):
        cells = round(2 * REACH / grain) + 3
        coarse = rng.standard_normal((cells, cells)).astype(np.float32)
        total += weight * np.asarray(cv2.resize(coarse, (_TEXELS, _TEXELS), interpolation=cv2.INTER_CUBIC))
    return total


def _smooth(layer: Float32Array, sigma: float) -> Float32Array:
    return np.asarray(cv2.GaussianBlur(layer, (0, 0), sigma * _PER_MM), dtype=np.float32)


def _smoothstep(values: Float32Array, low: float, high: float) -> Float32Array:
    x = np.clip((values - low) / (high - low), 0, 1)
    return np.asarray(x * x * (3 - 2 * x), dtype=np.float32)


def _filled(colour: tuple[float, float, float]) -> Float32Array:
    return np.broadcast_to(np.array(colour, dtype=np.float32), (_TEXELS, _TEXELS, 3))


def _mix(first: Float32Array, second: Float32Array, share: Float32Array) -> Float32Array:
    return np.asarray(first + (second - first) * share[:, :, None], dtype=np.float32)
