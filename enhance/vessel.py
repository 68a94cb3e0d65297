"""The preset `vessel`: the paper's brightness and detail, gentle colour, and more of what looks like blood.

An own method beside the paper's, which stays the default. Its claim is visibility only: it darkens and
reddens narrow dark structures as more blood would, whether or not they are vessels.
"""

from __future__ import annotations

from dataclasses import dataclass as plain_dataclass
from typing import Annotated, Any, Final

import cv2
import numpy as np
from annotated_types import Interval, Unit
from numpy.typing import NDArray
from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from enhance import vessel_kernels
from enhance.brightness import level, z_from_level
from enhance.enhancer import Enhancer
from enhance.image import AnyImage, Float32Image, ImageError, full_scale
from enhance.morphology import opening
from enhance.params import DFactor, EnhanceParams
from enhance.result import EnhanceResult
from enhance.saturation import pull
from enhance.shown import Pixels, Shown
from enhance.statistics import Statistics

ABSORPTION: Final = np.array([0.15, 1.0, 0.8], dtype=np.float32)
"""Of haemoglobin in the red, green and blue of a camera, relative to green (coarse: sensors differ)."""
GREY: Final = np.ones(3, dtype=np.float32)
"""For grey images."""


@dataclass(
    frozen=True,
    kw_only=True,
    config=ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True),
)
class VesselParams:
    """Parameters of the preset `vessel`, with their ranges; each is described below its field.

    Raises:
        pydantic.ValidationError: (a ValueError) a value out of its range.

    Example:
        >>> from enhance import VesselParams
        >>> VesselParams(strength=3.0).radius
        16
    """

    strength: Annotated[float, Interval(ge=0.0, le=4.0)] = 2.4
    """How much of the detected blood is added again: 0 is off."""
    radius: Annotated[int, Interval(ge=2, le=128), Unit("px")] = 16
    """Structures wider than twice this are not changed."""
    shading: Annotated[float, Interval(ge=0.0, le=1.0)] = 0.5
    """Share of the darkness common to red and green that is treated as shadow, not blood."""
    coring: Annotated[float, Interval(ge=0.0, le=4.0)] = 1.5
    """Structures weaker than this many times the image's median density are hardly strengthened."""
    lift: Annotated[float, Interval(ge=0.0, le=1.0)] = 0.5
    """Share of the brightening of Eq 1 to apply."""
    gamma: Annotated[float, Interval(ge=0.5, le=2.0)] = 1.05
    """Exponent applied to V afterwards: above 1 darkens the mid-tones; black and white stay."""
    d_factor: DFactor = 1.0
    """Multiplies d in Eq 11: smaller means more colour. 0 leaves saturation unchanged."""
    most_color: Annotated[float, Interval(ge=1.0, le=4.0)] = 1.4
    """Upper limit of the saturation gain, which is at least 1: greys and highlights keep their colour."""


VESSEL: Final = VesselParams()


def enhance_vessels(
    image: AnyImage,
    params: VesselParams = VESSEL,
    *,
    tissue_mask: AnyImage | None = None,
    statistics: Statistics | None = None,
    pixels: Pixels = "automatic",
) -> EnhanceResult:
    """Make vessels visible as if they held more blood (Beer-Lambert law), with colours close to the original.

    1. Noise of colour, not of brightness, is smoothed away. V never rises by that.
    2. V: Eqs 1 and 7-10 of the paper with part of its brightening, then `gamma`.
    3. S: Eqs 11 and 12 with the gain kept between 1 and `most_color`.
    4. What is narrow and absorbs green more than red is a density of blood: the top-hat (the image less its
       morphological opening, of radius `radius`) of `shading` log R - log G. Slow shading falls out, and of
       steps between tissues little is left. R, G and B are attenuated by it as haemoglobin does. Nothing gets
       brighter, so nothing saturates.

    For many images, or many parameters of one, a `VesselEnhancer` is faster.

    Args:
        image: (H, W), (H, W, 3) RGB in this order, or (H, W, 4) RGBA; types as of `enhance`. Of grey
            images all darkness counts as blood.
        tissue_mask: as of `enhance`.
        statistics: of a clip, measured with any parameters of three scales; None: of this image.
        pixels: as of `enhance`.

    Raises:
        ImageError: as `enhance`.

    Example:
        >>> import numpy as np
        >>> from enhance import enhance_vessels, vessel_contrast
        >>> image = np.full((96, 96, 3), (200, 120, 110), np.uint8)
        >>> vessel = np.zeros((96, 96), bool)
        >>> vessel[:, 46:50] = True
        >>> image[vessel] = 190, 100, 95
        >>> result = enhance_vessels(image)
        >>> vessel_contrast(result.image, vessel) > vessel_contrast(image, vessel)
        True
    """
    enhancer = VesselEnhancer()
    enhancer.show(image, tissue_mask, pixels=pixels)
    return enhancer.enhance(params, statistics=statistics)


@plain_dataclass(frozen=True, eq=False)
class _Planes:
    """Memory for what follows from an image of one size alone."""

    sharp: NDArray[np.float32]
    """(3, H, W): R, G and B in [0, 1]."""
    smooth: NDArray[np.float32]
    """(3, H, W), blurred; then red and green blurred more."""
    calm: NDArray[np.float32]
    """(H, W, 3) without noise of colour."""
    fade: Float32Image
    absorbed: Float32Image

    @classmethod
    def of(cls, shape: tuple[int, ...]) -> _Planes:
        apart, single = (3, *shape[:2]), shape[:2]
        return cls(
            sharp=np.empty(apart, np.float32),
            smooth=np.empty(apart, np.float32),
            calm=np.empty((*single, 3), np.float32),
            fade=np.empty(single, np.float32),
            absorbed=np.empty(single, np.float32),
        )


@plain_dataclass(frozen=True, eq=False)
class _Found:
    """Structures that absorb green, by what they were looked for with."""

    asked: tuple[int, float]
    """Radius and shading."""
    opened: Float32Image
    """(H, W), the background of `_Planes.absorbed`."""
    middle: float
    """Median of the density."""


class VesselEnhancer:
    """Show it an image, then enhance it as often as the parameters change; see `enhance_vessels`.

    A new strength, coring, gamma, d-factor or colour limit neither filters nor detects structures
    again. Working memory is reused from image to image. Not thread-safe.

    Example:
        >>> import numpy as np
        >>> from enhance import VesselEnhancer, VesselParams
        >>> enhancer = VesselEnhancer()
        >>> enhancer.show(np.random.default_rng(0).integers(0, 200, (48, 64, 3), dtype=np.uint8))
        >>> [enhancer.enhance(VesselParams(strength=x)).image.shape for x in (1.0, 2.0)]
        [(48, 64, 3), (48, 64, 3)]
    """

    def __init__(self) -> None:
        self._paper = Enhancer()
        self._planes = _Planes.of((0, 0))
        self._shown: Shown | None = None
        self._calmed: Shown | None = None
        self._level = 0
        self._found: _Found | None = None
        self._toned: tuple[EnhanceParams, Statistics | None, EnhanceResult] | None = None

    def show(
        self, image: AnyImage, tissue_mask: AnyImage | None = None, *, pixels: Pixels = "automatic"
    ) -> None:
        """Take the next image; see `enhance_vessels` for all three. It must not change while it is in use.

        Raises:
            ImageError: an image, mask or field that cannot be used; the previous image is kept.
        """
        self._shown = Shown.of(image, tissue_mask, pixels)

    def _look_within(self, statistics: Statistics | None) -> Shown:
        """The shown image within its field of view, or that of the statistics, calmed."""
        if self._shown is None:
            raise ImageError("expected an image to be shown before it is enhanced")
        self._shown = now = self._shown.within(statistics)
        if now is not self._calmed:
            if self._planes.calm.shape != now.pixels.shape:
                self._planes = _Planes.of(now.pixels.shape)
            keep = now.kept()
            self._level = level(self._calm(now.pixels, keep))
            self._paper.show(self._planes.calm, keep if len(keep) else None, pixels=now.field or "all")
            self._found, self._toned, self._calmed = None, None, now
        return now

    def _calm(self, pixels: NDArray[Any], keep: NDArray[np.uint8]) -> NDArray[np.int64]:
        """Fill all planes but `absorbed`; the histogram of V."""
        planes = self._planes
        vessel_kernels.split(pixels, np.float32(full_scale(pixels.dtype)), planes.sharp)
        for sharp, smooth in zip(planes.sharp, planes.smooth, strict=True):
            cv2.GaussianBlur(sharp, (0, 0), 0.8, dst=smooth)
        histograms = np.empty((-(-len(pixels) // vessel_kernels.BLOCK), vessel_kernels.BINS), np.int64)
        vessel_kernels.calm(planes.sharp, planes.smooth, keep, planes.calm, planes.fade, histograms)
        for sharp, smooth in zip(planes.sharp[:2], planes.smooth[:2], strict=True):
            cv2.GaussianBlur(sharp, (0, 0), 1.0, dst=smooth)
        return np.asarray(histograms.sum(axis=0))

    def enhance(
        self, params: VesselParams = VESSEL, *, statistics: Statistics | None = None
    ) -> EnhanceResult:
        """The image that is shown, enhanced.

        Raises:
            ImageError: statistics that cannot be used, no pixel to measure, or no image shown.
        """
        now = self._look_within(statistics)
        toned, found = self._tone(params, statistics), self._find(now, params)
        out = np.empty_like(now.pixels)
        vessel_kernels.finish(
            np.asarray(toned.image),
            self._planes.fade,
            self._planes.absorbed,
            found.opened,
            np.float32(params.gamma),
            np.float32(pull(toned.statistics.saturation_mean, params.d_factor)),
            np.float32(params.most_color),
            np.float32(params.strength),
            np.float32(params.coring * found.middle),
            GREY if now.is_grey else ABSORPTION,
            np.float32(now.full),
            now.pixels,
            now.spans,
            out,
        )
        return EnhanceResult(now.finished(out), toned.statistics, ())

    def _tone(self, params: VesselParams, statistics: Statistics | None) -> EnhanceResult:
        """V of the paper with part of its brightening, hue and S as they are."""
        dark = self._level if statistics is None else statistics.level
        paper = EnhanceParams(z=1 - (1 - z_from_level(dark)) * params.lift, d_factor=0.0)
        if self._toned is None or self._toned[:2] != (paper, statistics):
            self._toned = paper, statistics, self._paper.enhance(paper, statistics=statistics)
        return self._toned[2]

    def _find(self, now: Shown, params: VesselParams) -> _Found:
        """What is narrow and absorbs green more than red; of grey pictures, what is narrow and dark."""
        asked = params.radius, 0.0 if now.is_grey else params.shading
        if self._found is None or self._found.asked != asked:
            red, green = self._planes.smooth[:2]
            absorbed = self._planes.absorbed
            vessel_kernels.absorb(red, green, np.float32(asked[1]), absorbed)
            background = opening(absorbed, params.radius)
            sparse = np.maximum(absorbed[::3, ::3] - background[::3, ::3], 0)
            seen = sparse if now.field is None or now.field.is_whole else sparse[now.field.mask()[::3, ::3]]
            self._found = _Found(asked, background, float(np.median(seen)) if seen.size else 0.0)
        return self._found
