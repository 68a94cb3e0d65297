"""A grid of settings tried on one image: which values, and the results, the best first."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from itertools import product
from time import perf_counter
from typing import Any, Final

import numpy as np
from pydantic import ValidationError

from app.console.flags import AUTO, problem
from app.enhancement.measures import SMALLER_IS_BETTER, Lengths, MeasuredOver, Measures, Original
from app.enhancement.methods import EnhancementSettings, MethodEnhancer, load_kernels
from app.errors import UserError
from app.files.image_files import ArrayImage
from enhance import Statistics
from enhance.image import BoolImage
from enhance.noise import NoiseCut
from enhance.shown import Pixels

MOST_CELLS = 400
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
        wanted = f"{name}=FROM:TO:COUNT with numbers and COUNT from 1 to {MOST_CELLS}"
        raise UserError(f"--vary: expected {wanted}, got {said!r}")
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
    noise_cut: NoiseCut = "unclipped",
    lengths: Lengths = "by size",
) -> Iterator[Cell]:
    """Enhance and measure, one after another, in the order in which least is computed twice.

    Args:
        tissue_mask: (H, W), True = counts in the statistics; None: all.
        pixels: what is enhanced, as of `enhance.enhance`.
        measured_over: what is measured.
        noise_cut: how its noise is.
        lengths: what vessels are measured by.

    Raises:
        ImageError: a picture that cannot be enhanced.
    """
    original, order = Original.of(image, lengths), working_order(wanted)
    for one in order[:1]:
        load_kernels(one.params, image)
    enhancer = MethodEnhancer()
    enhancer.show(image, tissue_mask, pixels)
    for setting in order:
        start = perf_counter()
        result = enhancer.enhance(setting.params)
        milliseconds = 1000 * (perf_counter() - start)
        measures = original.measures(result.image, milliseconds, measured_over, noise_cut)
        yield Cell(setting, result.image, result.statistics, measures)


def working_order(wanted: Sequence[Setting]) -> list[Setting]:
    """Settings that share what takes longest follow each other."""
    return sorted(wanted, key=lambda one: [str(getattr(one.params, name, "")) for name in SLOWEST])


def ranked(measured: Sequence[Measures], metric: str) -> list[int]:
    """Places of the cells, the best first; what could not be measured last."""

    def worth(place: int) -> float:
        value = float(getattr(measured[place], metric))
        if math.isnan(value):
            return math.inf
        return value if metric in SMALLER_IS_BETTER else -value

    return sorted(range(len(measured)), key=worth)
