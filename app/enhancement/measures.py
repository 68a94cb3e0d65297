"""How visible an enhanced picture makes what is in its original, in numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Final, Literal

from app.files.image_files import ArrayImage
from enhance.color_difference import vessel_color_difference
from enhance.image import BoolImage
from enhance.metrics import dvbv_otsu, line_scale, saturated_share, vessel_contrast
from enhance.noise import NoiseCut, chroma_noise_gain, flat_tissue, noise_gain
from enhance.ridges import creases, field_of_view, vessel_mask

MeasuredOver = Literal["field of view", "whole image"]
"""The pixels that DV, BV and the saturated share are of; every other measure is of the field of view."""

Lengths = Literal["by size", "in pixels"]
"""Widths of vessels and what is left out beside them: in an image below 640 pixels as many fewer."""


@dataclass(frozen=True)
class Measures:
    """What is measured of an enhanced picture; `DEFINITIONS` says how."""

    dv: float
    bv: float
    dv_bv: float
    vessel_contrast: float
    noise_gain: float
    saturated_share: float
    milliseconds: float
    color_difference: float = math.nan
    chroma_noise_gain: float = math.nan


METRICS: Final = tuple(item.name for item in fields(Measures))
SMALLER_IS_BETTER: Final = frozenset(
    {"bv", "noise_gain", "saturated_share", "milliseconds", "chroma_noise_gain"}
)
DEFINITIONS: Final[Mapping[str, str]] = {
    "dv_bv": "inferred definition: variances of grey above and below the image's own Otsu threshold, "
    "over the field of view",
    "vessel_contrast": "Weber contrast in green of the original's strongest dark ridges against a ring",
    "noise_gain": "high-frequency noise over that of the original, where the original is flat, without "
    "clipped pixels",
    "saturated_share": "share of the field of view whose largest channel is 250 of 255 or more",
    "color_difference": "CIEDE2000 between the same ridges and their ring, mean over blocks of 64 "
    "pixels; of fewer in images below 640 pixels",
    "chroma_noise_gain": "as noise_gain, of the colours alone, averaged over blocks large enough for the "
    "original's to exceed rounding",
    "milliseconds": "for what this cell changes, after the cells computed before it",
}
DEFINITIONS_BEFORE: Final[Mapping[str, str]] = {
    "dv_bv": "inferred definition: variances of grey above and below the image's own Otsu threshold",
    "saturated_share": "share of pixels whose largest channel is 250 of 255 or more",
}
"""Of those that are of the whole image, its black surround included, in files that ask for that."""
NOISE_BEFORE: Final[Mapping[str, str]] = {
    "noise_gain": "high-frequency noise over that of the original, where the original is flat",
    "chroma_noise_gain": "as noise_gain, of the colours alone",
}
"""Of the noise gains in files that ask for a cut of before."""
LENGTHS_BEFORE: Final[Mapping[str, str]] = {
    "color_difference": "CIEDE2000 between the same ridges and their ring, mean over blocks of 64 pixels"
}
"""Of what is measured by lengths in pixels, in files that ask for that."""
LEAST: Final = 0.5
"""Of the colour difference (CIEDE2000, where 1 is just noticeable): less is nobody's loss."""
LITTLE: Final = 1.1
"""Times the colour difference of before: less is hardly clearer."""


@dataclass(frozen=True)
class VesselsSeen:
    """Colour difference (CIEDE2000) of vessels to what lies beside them, before and after."""

    before: float
    after: float

    @property
    def are_fainter(self) -> bool:
        return self.after < self.before - LEAST

    @property
    def are_hardly_clearer(self) -> bool:
        """Or a little fainter, where there is something to be seen."""
        return self.before >= 1 and self.after < LITTLE * self.before


@dataclass(frozen=True, eq=False)
class Original:
    """A picture whose enhanced ones are measured, with what is found in it alone."""

    image: ArrayImage
    view: BoolImage
    """(H, W), True in its field of view."""
    vessels: BoolImage
    """(H, W), True in its strongest dark ridges."""
    scale: float = 1.0
    """Of the lengths that these are measured by."""

    @classmethod
    def of(cls, image: ArrayImage, lengths: Lengths = "by size") -> Original:
        """Raises ImageError."""
        view = field_of_view(image)
        scale = line_scale(image) if lengths == "by size" else 1.0
        return cls(image, view, vessel_mask(image, tissue_mask=view, scale=scale), scale)

    def measures(
        self,
        enhanced: ArrayImage,
        milliseconds: float = 0.0,
        measured_over: MeasuredOver = "field of view",
        noise_cut: NoiseCut = "unclipped",
    ) -> Measures:
        """Of a picture that was made of this one in that time. Raises ImageError."""
        pixels = self.view if measured_over == "field of view" else None
        otsu = dvbv_otsu(enhanced, tissue_mask=pixels)
        return Measures(
            dv=otsu.dv,
            bv=otsu.bv,
            dv_bv=otsu.ratio,
            vessel_contrast=vessel_contrast(enhanced, self.vessels, tissue_mask=self.view, scale=self.scale),
            noise_gain=noise_gain(
                enhanced, self.image, tissue_mask=self.view, cut=noise_cut, flat=self._flat
            ),
            saturated_share=saturated_share(enhanced, tissue_mask=pixels),
            milliseconds=milliseconds,
            color_difference=vessel_color_difference(
                enhanced, self.vessels, tissue_mask=self.view, scale=self.scale
            ),
            chroma_noise_gain=chroma_noise_gain(
                enhanced, self.image, tissue_mask=self.view, cut=noise_cut, flat=self._flat
            ),
        )

    @cached_property
    def _flat(self) -> BoolImage:
        return flat_tissue(self.image, self.view)

    @cached_property
    def own(self) -> Measures:
        """Of this picture itself. Raises ImageError."""
        return self.measures(self.image)

    def vessels_in(self, enhanced: ArrayImage, measured: Measures) -> VesselsSeen | None:
        """Of an image that was made of this one, and `measured`: of all dark lines or of those alone that are
        no creases, which brightening opens, whichever gain more. None: they cannot be measured."""
        every = VesselsSeen(self.own.color_difference, measured.color_difference)
        if every.after >= LITTLE * every.before:
            return every
        vessels, tissue = self._open
        plain = VesselsSeen(
            *(
                vessel_color_difference(image, vessels, tissue_mask=tissue, scale=self.scale)
                for image in (self.image, enhanced)
            )
        )
        if not all(map(math.isfinite, (every.before, every.after, plain.before, plain.after))):
            return None
        return max(every, plain, key=lambda seen: seen.after - seen.before)

    @cached_property
    def _open(self) -> tuple[BoolImage, BoolImage]:
        """The lines that are no creases, and the tissue without creases."""
        tissue = self.view & ~creases(self.image, scale=self.scale)
        return vessel_mask(self.image, tissue_mask=tissue, scale=self.scale), tissue
