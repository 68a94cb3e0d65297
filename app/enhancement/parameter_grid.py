"""A grid of settings tried on one image: which values, the results, and their measures."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from itertools import product
from time import perf_counter
from types import MappingProxyType
from typing import Any, Final, Literal

import numpy as np
from pydantic import ValidationError

from app.console.flags import AUTO, problem
from app.enhancement.methods import EnhancementSettings, MethodEnhancer, load_kernels
from app.errors import UserError
from app.files.image_files import ArrayImage
from enhance import Statistics
from enhance.color_difference import vessel_color_difference
from enhance.image import BoolImage
from enhance.metrics import dvbv_otsu, saturated_share, vessel_contrast
from enhance.noise import NoiseCut, chroma_noise_gain, noise_gain
from enhance.ridges import field_of_view, vessel_mask
from enhance.shown import Pixels

MOST_CELLS = 400
MeasuredOver = Literal["field of view", "whole image"]
"""The pixels that DV, BV and the saturated share are of; every other measure is of the field of view."""
SLOWEST: Final = ("radii", "subsample", "eps", "radius", "shading")
"""What an enhancer computes first: these vary least often, so that most cells compute only their own part."""


@dataclass(frozen=True)
class Axis:
    """One parameter and the values that it takes."""

    name: str
    values: tuple[object, ...]
    """As text or number, for the parameters to judge."""

    def label(self, place: int) -> str:
        value = self.values[place]
        return f"{self.name} {value:.4g}" if isinstance(value, float) else f"{self.name} {joined(value)}"


def joined(value: object) -> object:
    """Several values as one text."""
    return "/".join(map(str, value)) if isinstance(value, tuple) else value


@dataclass(frozen=True)
class Measures:
    """What is measured of one cell; `DEFINITIONS` says how."""

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
DEFINITIONS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "dv_bv": "inferred definition: variances of grey above and below the image's own Otsu threshold, "
        "over the field of view",
        "vessel_contrast": "Weber contrast in green of the original's strongest dark ridges against a ring",
        "noise_gain": "high-frequency noise over that of the original, where the original is flat",
        "saturated_share": "share of the field of view whose largest channel is 250 of 255 or more",
        "color_difference": "CIEDE2000 between the same ridges and their ring, mean over blocks of 64 pixels",
        "chroma_noise_gain": "as noise_gain, of the colours alone",
        "milliseconds": "for what this cell changes, after the cells computed before it",
    }
)
DEFINITIONS_BEFORE: Final[Mapping[str, str]] = MappingProxyType(
    {
        "dv_bv": "inferred definition: variances of grey above and below the image's own Otsu threshold",
        "saturated_share": "share of pixels whose largest channel is 250 of 255 or more",
    }
)
"""Of those that are of the whole image, its black surround included, in files that ask for that."""


@dataclass(frozen=True)
class Setting:
    """One cell of the grid, before it is tried."""

    places: tuple[int, ...]
    """Of its value on each axis."""
    label: str
    params: EnhancementSettings


@dataclass(frozen=True, eq=False)
class Cell:
    """A setting tried: (H, W, 3) uint8, or as the picture is."""

    setting: Setting
    image: ArrayImage
    statistics: Statistics
    measures: Measures


def axis(text: str, kind: type[EnhancementSettings]) -> Axis:
    """`NAME=FROM:TO:COUNT`, both ends included, or `NAME=VALUE,VALUE,...`; slashes join a value of several
    numbers, as in `radii=4/16/64,2/8`.

    Raises:
        UserError: another form, or no parameter of this name.
    """
    name, sign, said = text.partition("=")
    name = name.strip().replace("-", "_")
    known = [item.name for item in fields(kind)]
    if name not in known:
        raise UserError(f"--vary: expected one of {', '.join(known)}, got {name!r}")
    if not sign or not said.strip():
        raise UserError(f"--vary: expected {name}=FROM:TO:COUNT or {name}=VALUE,VALUE,…, got {text!r}")
    values = _range(name, said) if ":" in said else tuple(_value(word) for word in said.split(","))
    return Axis(name, tuple(dict.fromkeys(values)))


def _range(name: str, said: str) -> tuple[object, ...]:
    parts = said.split(":")
    try:
        first, last, count = float(parts[0]), float(parts[1]), int(parts[2])
    except (IndexError, ValueError):
        first = last = math.nan
        count = 0
    if len(parts) != 3 or not (math.isfinite(last - first) and 1 <= count <= MOST_CELLS):
        raise UserError(f"--vary: expected {name}=FROM:TO:COUNT with numbers and COUNT >= 1, got {said!r}")
    if count == 1 and first != last:
        raise UserError(f"--vary: expected COUNT >= 2 from {parts[0]} to {parts[1]}, got {name}={said}")
    step = abs(last - first) / max(count - 1, 1)
    if count == 1 or step == 0:
        return (first,)
    # Six decimals, or six digits of a small step: short to type again, and no two alike.
    decimals = max(6, 5 - math.floor(math.log10(step)))
    between = (round(float(value), decimals) for value in np.linspace(first, last, count)[1:-1])
    return first, *between, last


def _value(word: str) -> object:
    word = word.strip()
    return word if "/" not in word else tuple(part.strip() for part in word.split("/"))


def settings(base: EnhancementSettings, axes: Sequence[Axis]) -> tuple[Setting, ...]:
    """Every combination, the last axis varying fastest.

    Raises:
        UserError: no axis or one twice, too many cells, or a value that the parameters refuse.
    """
    names = [one.name for one in axes]
    count = math.prod(len(one.values) for one in axes)
    if not axes or len(set(names)) < len(names):
        raise UserError(
            f"expected one or more parameters to vary, each once, got {', '.join(names) or 'none'}"
        )
    if count > MOST_CELLS:
        raise UserError(f"expected at most {MOST_CELLS} images, got {count}: vary fewer values")
    return tuple(
        _setting(base, axes, places) for places in product(*(range(len(one.values)) for one in axes))
    )


def _setting(base: EnhancementSettings, axes: Sequence[Axis], places: tuple[int, ...]) -> Setting:
    changes: dict[str, Any] = {
        one.name: None if one.values[place] == AUTO else one.values[place]
        for one, place in zip(axes, places, strict=True)
    }
    try:
        params = replace(base, **changes)
    except ValidationError as error:
        raise UserError(f"--vary: {problem(error)}") from error
    label = " · ".join(one.label(place) for one, place in zip(axes, places, strict=True))
    return Setting(places, label, params)


def tried(
    image: ArrayImage,
    wanted: Sequence[Setting],
    tissue_mask: BoolImage | None = None,
    pixels: Pixels = "automatic",
    measured_over: MeasuredOver = "field of view",
    noise_cut: NoiseCut = "by rank",
) -> Iterator[Cell]:
    """Enhance and measure, one after another, in the order in which least is computed twice.

    Args:
        tissue_mask: (H, W), True = counts in the statistics; None: all.
        pixels: what is enhanced, as of `enhance.enhance`.
        measured_over: what is measured.
        noise_cut: how its noise is.

    Raises:
        ImageError: a picture that cannot be enhanced.
    """
    view = field_of_view(image)
    vessels = vessel_mask(image, tissue_mask=view)
    order = working_order(wanted)
    for one in order[:1]:
        load_kernels(one.params, image)
    enhancer = MethodEnhancer()
    enhancer.show(image, tissue_mask, pixels)
    for setting in order:
        start = perf_counter()
        result = enhancer.enhance(setting.params)
        milliseconds = 1000 * (perf_counter() - start)
        measures = measured(result.image, image, vessels, view, milliseconds, measured_over, noise_cut)
        yield Cell(setting, result.image, result.statistics, measures)


def working_order(wanted: Sequence[Setting]) -> list[Setting]:
    """Settings that share what takes longest follow each other."""
    return sorted(wanted, key=lambda one: [str(getattr(one.params, name, "")) for name in SLOWEST])


def measured(
    image: ArrayImage,
    original: ArrayImage,
    vessels: BoolImage,
    view: BoolImage,
    milliseconds: float,
    measured_over: MeasuredOver = "field of view",
    noise_cut: NoiseCut = "by rank",
) -> Measures:
    """Of an enhanced picture; `vessels` and `view` are masks (H, W) of the original."""
    pixels = view if measured_over == "field of view" else None
    otsu = dvbv_otsu(image, tissue_mask=pixels)
    return Measures(
        dv=otsu.dv,
        bv=otsu.bv,
        dv_bv=otsu.ratio,
        vessel_contrast=vessel_contrast(image, vessels, tissue_mask=view),
        noise_gain=noise_gain(image, original, tissue_mask=view, cut=noise_cut),
        saturated_share=saturated_share(image, tissue_mask=pixels),
        milliseconds=milliseconds,
        color_difference=vessel_color_difference(image, vessels, tissue_mask=view),
        chroma_noise_gain=chroma_noise_gain(image, original, tissue_mask=view, cut=noise_cut),
    )


def ranked(measured: Sequence[Measures], metric: str) -> list[int]:
    """Places of the cells, the best first; what could not be measured last."""

    def worth(place: int) -> float:
        value = float(getattr(measured[place], metric))
        if math.isnan(value):
            return math.inf
        return value if metric in SMALLER_IS_BETTER else -value

    return sorted(range(len(measured)), key=worth)
