"""The preset `vessel`: the paper's brightness and detail, gentle colour, and more of what looks like blood.

An own method beside the paper's, which stays the default. Its claim is visibility only: it darkens and
reddens narrow dark structures as more blood would, whether or not they are vessels.
"""

from __future__ import annotations

from typing import Annotated, Final

import cv2
import numpy as np
from annotated_types import Interval, Unit
from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from enhance.brightness import level, value, value_histogram, z_from_level
from enhance.image import AnyImage, Float32Image, read_mask, read_picture
from enhance.params import EnhanceParams
from enhance.pipeline import enhance
from enhance.result import EnhanceResult
from enhance.saturation import recolor, saturation, stretch
from enhance.statistics import Statistics

ABSORPTION: Final = np.array([0.15, 1.0, 0.8], dtype=np.float32)
"""Of haemoglobin in the red, green and blue of a camera, relative to green (coarse: sensors differ)."""
LUMA: Final = np.array([0.299, 0.587, 0.114], dtype=np.float32)
FLOOR: Final = np.float32(8 / 255)
"""Added before a logarithm, so that noise in the dark is no structure."""
MOST: Final = np.float32(0.5)
"""Bound on the density that is found, a natural logarithm: at strength 1, green falls to 61 % at most."""
DIM: Final = (0.15, 0.4)
"""V between which `gamma` and the layer fade in: dark vessels do not become black."""


@dataclass(
    frozen=True,
    kw_only=True,
    config=ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True),
)
class VesselParams:
    """Parameters of the preset `vessel`.

    Raises:
        pydantic.ValidationError: (a ValueError) a value out of its range.
    """

    strength: Annotated[float, Interval(ge=0.0, le=4.0)] = 2.0
    """How much of the blood that is found is added once more: 0 is off."""
    radius: Annotated[int, Interval(ge=2, le=128), Unit("px")] = 16
    """Structures wider than twice this are left alone."""
    shading: Annotated[float, Interval(ge=0.0, le=1.0)] = 0.5
    """Share of darkness that red and green have in common and that counts as shadow, not as blood."""
    coring: Annotated[float, Interval(ge=0.0, le=4.0)] = 1.5
    """Structures weaker than this many times the picture's median density are hardly strengthened."""
    lift: Annotated[float, Interval(ge=0.0, le=1.0)] = 0.85
    """Share of the brightening of Eq 1 that is applied."""
    gamma: Annotated[float, Interval(ge=0.5, le=2.0)] = 1.2
    """Exponent of V afterwards: above 1 deepens the middle tones; black and white stay."""
    d_factor: Annotated[float, Interval(ge=0.0, le=4.0)] = 0.5
    """Multiplies d in Eq 11: smaller means more colour. 0 leaves saturation alone."""
    most_color: Annotated[float, Interval(ge=1.0, le=4.0)] = 1.4
    """Bound on the gain of saturation, which never falls below 1: greys and highlights keep their colour."""


VESSEL: Final = VesselParams()


def enhance_vessels(
    image: AnyImage,
    params: VesselParams = VESSEL,
    *,
    tissue_mask: AnyImage | None = None,
    statistics: Statistics | None = None,
) -> EnhanceResult:
    """Make vessels visible as if they held more blood (Beer-Lambert law), colours kept near the original.

    1. Noise of colour, not of brightness, is smoothed away. V never rises by that.
    2. V: Eqs 1 and 7-10 of the paper with part of its brightening, then `gamma`.
    3. S: Eqs 11 and 12 with the gain kept between 1 and `most_color`.
    4. What is narrow and absorbs green more than red is a density of blood (`blood_density`); R, G and B
       are attenuated by it as haemoglobin does. Nothing gets brighter, so nothing saturates.

    Args:
        image: (H, W), (H, W, 3) RGB in this order, or (H, W, 4) RGBA; types as of `enhance`. Of grey
            pictures all darkness counts as blood.
        tissue_mask: as of `enhance`.
        statistics: of a clip, measured with any parameters of three scales; None: of this image.

    Raises:
        ImageError: as `enhance`.
    """
    picture = read_picture(image)
    keep = read_mask(tissue_mask, picture)
    colors = picture.colors if picture.colors.ndim == 2 else _calm(picture.colors)
    bright = value(colors)
    dark = level(value_histogram(bright, keep)) if statistics is None else statistics.level
    z = 1 - (1 - z_from_level(dark)) * params.lift
    paper = EnhanceParams(z=z, d_factor=0.0)
    toned = enhance(colors, paper, tissue_mask=keep, statistics=statistics)
    colored = _colored(toned.image, toned.statistics, params)
    density = params.strength * _fade(bright) * blood_density(picture.colors, params)
    absorbed = density if colors.ndim == 2 else density[..., None] * ABSORPTION
    return EnhanceResult(picture.with_colors(colored * np.exp(-absorbed)), toned.statistics, ())


def blood_density(colors: Float32Image, params: VesselParams) -> Float32Image:
    """Optical density of narrow dark structures in green, (H, W) in [0, 0.5].

    The top-hat (image less its morphological opening, of radius `radius`) of `shading` log R - log G: narrow
    structures remain, while steps between tissues, slow shading and illumination fall out, without halos.
    """
    smooth = cv2.GaussianBlur(colors, (0, 0), 1.0) + FLOOR
    if colors.ndim == 2:
        absorbed = -np.log(smooth)
    else:
        absorbed = np.float32(params.shading) * np.log(smooth[..., 0]) - np.log(smooth[..., 1])
    found = np.maximum(absorbed - _opened(absorbed, params.radius), 0)
    noise = np.float32(params.coring) * np.median(found)
    cored = found**3 / (found**2 + noise**2 + np.float32(1e-12))
    return np.asarray(MOST * np.tanh(cored / MOST), dtype=np.float32)


def _opened(plane: Float32Image, radius: int) -> Float32Image:
    """Morphological opening, at a size that leaves the radius at 8 to 16 pixels, smoothed."""
    step = max(1, radius // 8)
    height, width = plane.shape
    small_size = (-(-width // step), -(-height // step))
    small = cv2.resize(plane, small_size, interpolation=cv2.INTER_AREA)
    reach = max(1, radius // step)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    opened = cv2.morphologyEx(small, cv2.MORPH_OPEN, disc, borderType=cv2.BORDER_REPLICATE)
    calm = cv2.GaussianBlur(opened, (0, 0), 0.6)
    return np.asarray(cv2.resize(calm, (width, height), interpolation=cv2.INTER_LINEAR), dtype=np.float32)


def _calm(colors: Float32Image) -> Float32Image:
    """Colour difference to luma, smoothed; at no pixel is any channel brighter than V was."""
    luma = (colors @ LUMA)[..., None]
    difference = cv2.GaussianBlur(colors - luma, (0, 0), 0.8)
    return np.asarray(np.clip(luma + difference, 0, value(colors)[..., None]), dtype=np.float32)


def _colored(toned: Float32Image, statistics: Statistics, params: VesselParams) -> Float32Image:
    bright = value(toned)
    """V and S of the result before absorption."""
    deepened = bright + _fade(bright) * (bright ** np.float32(params.gamma) - bright)
    if toned.ndim == 2:
        return deepened
    parts = saturation(toned, bright)
    stretched = stretch(parts, statistics.saturation_mean, params.d_factor)
    most = np.minimum(params.most_color * parts.chroma, 1)
    return recolor(toned, bright, parts, deepened, np.clip(stretched, parts.chroma, most))


def _fade(bright: Float32Image) -> Float32Image:
    """Smoothstep between the two V of DIM."""
    low, high = DIM
    t = np.clip((bright - low) / (high - low), 0, 1)
    return np.asarray(t * t * (3 - 2 * t), dtype=np.float32)
