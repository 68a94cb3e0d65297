"""The preset `vessel`: the paper's brightness and detail, gentle colour, and more of what looks like blood.

An own method beside the paper's, which stays the default. Its claim is visibility only: it darkens and
reddens narrow dark structures as more blood would, whether or not they are vessels.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Final

import cv2
import numpy as np
from annotated_types import Interval, Unit
from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from enhance.brightness import level, value_histogram, z_from_level
from enhance.image import AnyImage, Float32Image, read_mask, read_picture
from enhance.params import EnhanceParams
from enhance.pipeline import enhance
from enhance.result import EnhanceResult
from enhance.saturation import Saturation, stretch
from enhance.statistics import Statistics

ABSORPTION: Final = np.array([0.15, 1.0, 0.8], dtype=np.float32)
"""Of haemoglobin in the red, green and blue of a camera, relative to green (coarse: sensors differ)."""
GREY: Final = np.array([1.0], dtype=np.float32)
"""Of grey pictures."""
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
Planes = Sequence[Float32Image]
"""R, G and B, or a single grey, each (H, W) in [0, 1]: numpy works faster on planes than on pixels."""


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
    planes = _split(picture.colors)
    calm = _calm(planes)
    bright = _largest(calm)
    dark = level(value_histogram(bright, keep)) if statistics is None else statistics.level
    paper = EnhanceParams(z=1 - (1 - z_from_level(dark)) * params.lift, d_factor=0.0)
    toned = enhance(_merged(calm), paper, tissue_mask=keep, statistics=statistics)
    colored = _colored(_split(toned.image), toned.statistics.saturation_mean, params)
    density = np.float32(params.strength) * _fade(bright) * blood_density(planes, params)
    shares = ABSORPTION if len(planes) == 3 else GREY
    result = _merged([plane * np.exp(-share * density) for plane, share in zip(colored, shares, strict=True)])
    return EnhanceResult(picture.with_colors(result), toned.statistics, ())


def blood_density(planes: Planes, params: VesselParams) -> Float32Image:
    """Optical density of narrow dark structures in green, (H, W) in [0, 0.5].

    The top-hat (image less its morphological opening, of radius `radius`) of `shading` log R - log G: narrow
    structures remain, while slow shading falls out, and of steps between tissues little is left.

    Args:
        planes: R, G and B, or a single grey, (H, W) in [0, 1].
    """
    logs = [np.log(cv2.GaussianBlur(plane, (0, 0), 1.0) + FLOOR) for plane in planes[:2]]
    absorbed = -logs[0] if len(planes) == 1 else np.float32(params.shading) * logs[0] - logs[1]
    found = np.maximum(absorbed - _opened(absorbed, params.radius), 0)
    noise = np.float32(params.coring) * np.median(found[::3, ::3])
    square = found * found
    cored = found * square / (square + noise * noise + np.float32(1e-12))
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


def _calm(planes: Planes) -> Planes:
    """Differences of R, G and B to luma, smoothed; at no pixel is any channel brighter than V was."""
    if len(planes) == 1:
        return planes
    smooth = [cv2.GaussianBlur(plane, (0, 0), 0.8) for plane in planes]
    fine = sum(share * (plane - blurred) for share, plane, blurred in zip(LUMA, planes, smooth, strict=True))
    most = _largest(planes)
    return [np.clip(blurred + fine, 0, most) for blurred in smooth]


def _colored(planes: Planes, saturation_mean: float, params: VesselParams) -> Planes:
    """`gamma` on V, and S by Eqs 11 and 12 within its bounds; the hue stays (see `saturation.recolor`)."""
    bright = _largest(planes)
    deepened = bright + _fade(bright) * (bright ** np.float32(params.gamma) - bright)
    if len(planes) == 1:
        return [deepened]
    floor = np.maximum(bright, np.float32(1e-6))
    white = np.asarray(-_largest([-plane for plane in planes]) / floor, dtype=np.float32)
    chroma = np.maximum(1 - white, np.float32(1e-6))
    stretched = stretch(Saturation(chroma=chroma, white=white), saturation_mean, params.d_factor)
    most = np.minimum(np.float32(params.most_color), 1 / chroma)
    slope = deepened / floor * np.clip(stretched / chroma, 1, most)
    return [deepened - slope * (bright - plane) for plane in planes]


def _largest(planes: Planes) -> Float32Image:
    largest = planes[0]
    for plane in planes[1:]:
        largest = np.maximum(largest, plane)
    return largest


def _split(colors: AnyImage) -> Planes:
    return [np.asarray(plane, dtype=np.float32) for plane in cv2.split(colors)]


def _merged(planes: Planes) -> Float32Image:
    merged = planes[0] if len(planes) == 1 else cv2.merge(list(planes))
    return np.asarray(merged, dtype=np.float32)


def _fade(bright: Float32Image) -> Float32Image:
    """Smoothstep between the two V of DIM."""
    low, high = DIM
    t = np.clip((bright - np.float32(low)) / np.float32(high - low), 0, 1)
    return np.asarray(t * t * (3 - 2 * t), dtype=np.float32)
