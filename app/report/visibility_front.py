"""Contrast of vessels against noise, both over the original's: `vessel` at every strength, all others mixed.

Every other method is mixed with the original in five shares, so that each can be compared at the same noise.
`vessel` is not mixed: its strengths are taken as they are, with contrast in full, and without what it does
besides to brightness and colour, all of which are settings of the program.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from app.evaluation.mean import mean_of_finite
from app.report.visibility import Sample, methods
from enhance.color_difference import vessel_color_difference
from enhance.halos import edge_halo, highlight_halo
from enhance.metrics import vessel_cnr, vessel_contrast
from enhance.noise import noise_gain
from enhance.vessel import VesselEnhancer, VesselParams
from renderer.clip import BoolImage, ByteImage

ORIGINAL: Final = "original"
VESSEL: Final = "vessel"
DEFAULT: Final = VesselParams().strength
STRENGTHS: Final = (0.5, 1.0, 1.7, DEFAULT, 3.2, 4.0)
WAYS: Final[Mapping[str, VesselParams]] = {
    VESSEL: VesselParams(),
    "vessel, contrast 1": VesselParams(contrast=1.0, shading=0.0),
    "vessel, tone kept": VesselParams(lift=0.0, gamma=1.0, d_factor=0.0, most_exposure=1.0),
}
"""Of using `vessel`, each at every strength, by the name of its series."""
SHARES: Final = (0.2, 0.4, 0.6, 0.8, 1.0)
THIN: Final = 3
"""Pixels across."""
FEW: Final = 100
"""Pixels: where fewer are thin, all vessels count instead."""
SURROUNDINGS: Final = 32
"""Pixels: the blur that a vessel's darkness is measured against."""


@dataclass(frozen=True)
class Setting:
    """A method, and how much of it."""

    method: str
    amount: str
    is_default: bool = False

    @property
    def is_vessel(self) -> bool:
        """Made by VesselSplat's method, in any of its variants."""
        return self.method in WAYS


@dataclass(frozen=True, kw_only=True)
class Visibility:
    """How a result shows vessels, and what it costs; gains are over the original's."""

    noise: float
    """Gain, as of `noise_gain`."""
    contrast: float
    """Gain of Weber contrast."""
    thin: float
    """The same of thin vessels."""
    cnr: float
    """Gain of the contrast to noise ratio."""
    color: float
    """Gain of the colour difference, CIEDE2000."""
    auc: float
    """See area_under_curve."""
    highlight_halo: float
    """Grey levels; NaN: no highlight."""
    edge_halo: float
    """Grey levels; NaN: no strong edge."""


UNCHANGED: Final = Setting(ORIGINAL, "unchanged")
NAMES: Final = tuple(field.name for field in fields(Visibility))
GAINS: Final = ("noise", "contrast", "thin", "cnr", "color")
Seen = Mapping[Setting, Visibility]


def seen(one: Sample) -> dict[Setting, Visibility]:
    """Every method at every amount, on one image."""
    before = _amounts(one.image, one)
    return {setting: _visibility(image, whole, one, before) for setting, image, whole in results(one)}


def results(one: Sample) -> Iterator[tuple[Setting, ByteImage, ByteImage]]:
    """Every setting, its image, and what that was mixed from; the original is one."""
    enhancer = VesselEnhancer()
    enhancer.show(one.image, one.tissue)
    for way, params in WAYS.items():
        for strength in STRENGTHS:
            result = np.asarray(enhancer.enhance(replace(params, strength=strength)).image)
            yield Setting(way, f"strength {strength:g}", (way, strength) == (VESSEL, DEFAULT)), result, result
    for name, method in methods().items():
        if name == ORIGINAL:
            yield UNCHANGED, one.image, one.image
        elif name != VESSEL:
            whole = method(one.image, one.tissue)
            for share in SHARES:
                yield Setting(name, f"{share:.0%}", share == 1), mixed(whole, one.image, share), whole


def mixed(result: ByteImage, original: ByteImage, share: float) -> ByteImage:
    """So much of the result, the rest of the original."""
    both = np.float32(share) * result + np.float32(1 - share) * original
    return np.rint(both).astype(np.uint8)


def with_clipped(image: ByteImage, whole: ByteImage) -> ByteImage:
    """What was mixed from `whole`, clipped where that is: no noise of it can be told there."""
    return np.where((whole == 0) | (whole == 255), whole, image)


def averaged(images: Sequence[Seen]) -> dict[Setting, Visibility]:
    """Over images: geometric means of gains, else means of what was measured.

    Images whose original has nothing that a gain could be over are left out of it, for all settings alike. A
    gain is NaN where another image has none: a method that turns vessels bright.
    """
    return {setting: _averaged(setting, images) for setting in (images[0] if images else ())}


def has_vessels(found: Seen) -> bool:
    """Whether contrast and noise of an image can be compared with its original's."""
    return _is_defined("noise", found) and _is_defined("contrast", found)


def best_other(setting: Setting, found: Seen) -> Setting | None:
    """The most contrast with no more noise by any other method; None where all have more noise."""
    others = [
        other
        for other, one in found.items()
        if other.method != setting.method
        and not (other.is_vessel and setting.is_vessel)
        and one.noise <= found[setting].noise
        and math.isfinite(one.contrast)
    ]
    return max(others, key=lambda other: found[other].contrast, default=None)


def is_ahead(setting: Setting, found: Seen) -> bool:
    """Whether no other method has more contrast with no more noise."""
    other = best_other(setting, found)
    return other is None or found[other].contrast <= found[setting].contrast


def above_vessel(found: Seen) -> list[Setting]:
    """What has more contrast than any setting of `vessel` with no more noise, and than the original."""
    own = [one for setting, one in found.items() if setting.is_vessel]

    def reached(one: Visibility) -> float:
        return max([1.0, *(each.contrast for each in own if each.noise <= one.noise)])

    return [
        setting for setting, one in found.items() if not setting.is_vessel and one.contrast > reached(one)
    ]


def thin_part(vessels: BoolImage) -> BoolImage:
    """What an opening by a disc wider than THIN takes away, (H, W)."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (THIN + 2, THIN + 2))
    wide = cv2.morphologyEx(vessels.astype(np.uint8), cv2.MORPH_OPEN, disc)
    near = np.asarray(cv2.dilate(wide, disc)) > 0
    thin: BoolImage = vessels & ~near
    return thin if thin.sum() > FEW else vessels


def area_under_curve(image: ByteImage, one: Sample) -> float:
    """Of the ROC curve of the darkness of green against its blur, as a classifier of vessels; 0.5 is chance.

    Nobody tuned that classifier for a method. By ranks (Mann and Whitney), of quarters of grey levels. NaN:
    no vessel in the tissue, or nothing else.
    """
    green = image[..., 1].astype(np.float32)
    dark: NDArray[np.float32] = np.asarray(cv2.GaussianBlur(green, (0, 0), SURROUNDINGS)) - green
    inside, outside = dark[one.vessels & one.tissue], dark[~one.vessels & one.tissue]
    if not (inside.size and outside.size):
        return math.nan
    values, counts = np.unique(np.rint(np.concatenate((inside, outside)) * 4), return_counts=True)
    ranks = (np.cumsum(counts) - (counts - 1) / 2)[np.searchsorted(values, np.rint(inside * 4))]
    above = float(ranks.sum()) - len(inside) * (len(inside) + 1) / 2
    return above / (len(inside) * len(outside))


def _amounts(image: ByteImage, one: Sample) -> NDArray[np.float64]:
    """What gains are of: contrast, of thin vessels, CNR and colour difference."""
    mask, scale = one.tissue, one.scale
    return np.array(
        [
            vessel_contrast(image, one.vessels, tissue_mask=mask, scale=scale),
            vessel_contrast(image, thin_part(one.vessels), tissue_mask=mask, scale=scale),
            vessel_cnr(image, one.vessels, tissue_mask=mask, scale=scale),
            vessel_color_difference(image, one.vessels, tissue_mask=mask, scale=scale),
        ]
    )


def _visibility(image: ByteImage, whole: ByteImage, one: Sample, before: NDArray[np.float64]) -> Visibility:
    # Vessels are meant to change, so halos are measured beside them.
    other = one.tissue & ~one.vessels
    gains = np.divide(_amounts(image, one), before, out=np.full(before.shape, np.nan), where=before > 0)
    contrast, thin, cnr, color = gains.tolist()
    return Visibility(
        noise=noise_gain(with_clipped(image, whole), one.image, tissue_mask=one.tissue),
        contrast=contrast,
        thin=thin,
        cnr=cnr,
        color=color,
        auc=area_under_curve(image, one),
        highlight_halo=highlight_halo(image, one.image, tissue_mask=other),
        edge_halo=edge_halo(image, one.image, tissue_mask=other),
    )


def _averaged(setting: Setting, images: Sequence[Seen]) -> Visibility:
    def values(name: str) -> list[float]:
        counting = [each for each in images if name not in GAINS or _is_defined(name, each)]
        return [getattr(each[setting], name) for each in counting]

    means = {name: mean_of_finite(values(name)) for name in NAMES if name not in GAINS}
    return Visibility(
        **{name: _geometric(values(name)) for name in GAINS},
        **{name: math.nan if mean is None else mean for name, mean in means.items()},
    )


def _is_defined(gain: str, found: Seen) -> bool:
    return math.isfinite(getattr(found[UNCHANGED], gain))


def _geometric(gains: Sequence[float]) -> float:
    return math.exp(float(np.mean(np.log(gains)))) if min(gains, default=math.nan) > 0 else math.nan
