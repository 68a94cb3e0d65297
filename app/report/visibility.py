"""How all 2D methods change what can be seen, on images whose tissue and vessels are known or found."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.evaluation.mean import mean_of_finite
from enhance import EnhanceParams, enhance
from enhance.baselines import BASELINES, TAO_STAND_INS
from enhance.color_difference import vessel_color_difference
from enhance.metrics import (
    blackened_share,
    dvbv_local,
    dvbv_otsu,
    line_scale,
    saturated_share,
    vessel_cnr,
    vessel_contrast,
)
from enhance.noise import chroma_noise_gain, noise_gain
from enhance.ridges import field_of_view, vessel_mask
from enhance.vessel import enhance_vessels
from renderer.clip import BoolImage, ByteImage
from renderer.evenly import evenly
from renderer.measuring.interleaved_timing import interleaved_times
from renderer.phantom import Phantom, PhantomParams
from renderer.sources import open_clip

Method = Callable[[ByteImage, BoolImage], ByteImage]
PRINTED: Final = EnhanceParams(d_factor=1.0)
LAPS: Final = 5
COLUMNS: Final = (
    *("DV", "BV", "DV/BV", "whole", "DVloc", "BVloc", "ratio"),
    *("Weber", "CNR", "dE00", "sat%", "noise", "chroma", "black%", "ms"),
)
"""DV, BV and DV/BV by the inferred Otsu definition over the tissue; "whole" the same ratio over the whole
picture as in the paper; then dvbv_local over the tissue; Weber contrast, CNR and colour difference
(CIEDE2000) of the vessels; the saturated share of the tissue; noise gain, of all and of colours alone; share
of vessel pixels that became black."""


@dataclass(frozen=True, eq=False)
class Sample:
    """A picture and where its tissue and its vessels are."""

    image: ByteImage
    tissue: BoolImage
    vessels: BoolImage

    @property
    def scale(self) -> float:
        """Of the lengths that its vessels are measured by."""
        return line_scale(self.image)


def sample(image: ByteImage, tissue: BoolImage | None = None) -> Sample:
    """With the strongest dark ridges for vessels; without a mask all is tissue."""
    keep = np.ones(image.shape[:2], dtype=bool) if tissue is None else tissue
    return Sample(image, keep, vessel_mask(image, tissue_mask=keep, scale=line_scale(image)))


def of_clip(path: Path, count: int) -> Iterator[Sample]:
    """Of up to so many frames, evenly spread.

    Raises:
        ClipError: when it cannot be read.
    """
    clip = open_clip(path)
    for index in evenly(range(len(clip)), count):
        frame = clip.read_frame(index)
        tissue = frame.evaluation_mask
        yield sample(frame.image, field_of_view(frame.image) if tissue.all() else tissue)


def of_phantom(count: int) -> Iterator[Sample]:
    """So many frames, as large as those of an endoscope, whose vessels are known."""
    phantom = Phantom(PhantomParams(n_frames=count, width=640, height=512))
    for view in map(phantom.view, range(count)):
        yield Sample(view.frame.image, view.frame.evaluation_mask, view.vessel_mask)


def methods() -> Mapping[str, Method]:
    """By name; "paper" is the paper's as printed, "automatic" the same as people get it by default."""
    others = {name: (lambda image, _, run=run: run(image)) for name, run in BASELINES.items()}
    return {
        "original": lambda image, _: image,
        "paper": lambda image, tissue: enhance(image, PRINTED, tissue_mask=tissue, pixels="all").image,
        "automatic": lambda image, tissue: enhance(image, tissue_mask=tissue).image,
        "vessel": lambda image, tissue: enhance_vessels(image, tissue_mask=tissue).image,
        **others,
    }


def measured(methods: Mapping[str, Method], samples: Sequence[Sample]) -> dict[str, NDArray[np.float64]]:
    """The measures of each method by COLUMNS, means over the pictures where they are defined, else NaN; the
    time is the median of LAPS of every picture, in which the methods take turns."""
    works = [[partial(method, one.image, one.tissue) for method in methods.values()] for one in samples]
    times = 1e3 * np.median(np.hstack([interleaved_times(own, LAPS) for own in works]), axis=1)
    rows = [[_measures(work(), one) for work in own] for own, one in zip(works, samples, strict=True)]
    return {
        label: np.array([*map(mean_of_finite, zip(*own, strict=True)), time], dtype=np.float64)
        for label, own, time in zip(methods, zip(*rows, strict=True), times, strict=True)
    }


def pattern(ratio: Mapping[str, float]) -> tuple[str, bool, int]:
    """The methods of Table 3 by a ratio, highest first; whether the paper's and the original are above Wang,
    as there; and how many of the stand-ins for Tao are below Wang."""
    ranks = sorted(("paper", "original", "wang2020", *TAO_STAND_INS), key=lambda label: -ratio[label])
    shown = min(ratio["paper"], ratio["original"]) > ratio["wang2020"]
    below = sum(ratio[label] < ratio["wang2020"] for label in TAO_STAND_INS)
    return " > ".join(f"{label} {ratio[label]:.2f}" for label in ranks), shown, below


def _measures(image: ByteImage, one: Sample) -> tuple[float, ...]:
    otsu = dvbv_otsu(image, tissue_mask=one.tissue)
    local = dvbv_local(image, one.image, tissue_mask=one.tissue)
    return (
        *(otsu.dv, otsu.bv, otsu.ratio, dvbv_otsu(image).ratio, local.dv, local.bv, local.ratio),
        vessel_contrast(image, one.vessels, tissue_mask=one.tissue, scale=one.scale),
        vessel_cnr(image, one.vessels, tissue_mask=one.tissue, scale=one.scale),
        vessel_color_difference(image, one.vessels, tissue_mask=one.tissue, scale=one.scale),
        100 * saturated_share(image, tissue_mask=one.tissue),
        noise_gain(image, one.image, tissue_mask=one.tissue),
        chroma_noise_gain(image, one.image, tissue_mask=one.tissue),
        100 * blackened_share(image, one.image, one.vessels),
    )
