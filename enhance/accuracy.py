"""Error against run time: what each approximation costs in grey levels and saves in time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from statistics import median
from time import perf_counter
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from enhance.enhancer import Enhancer
from enhance.image import AnyImage, full_scale
from enhance.params import EnhanceParams
from enhance.reference import enhance_reference

Group = Literal["subsample", "nearest", "scales", "arithmetic", "left out", "kept in"]
EXACT: Final = EnhanceParams(omit_below=0.0)
SUBSETS: Final = ((4,), (16,), (64,), (4, 16), (4, 64), (16, 64), (4, 16, 64))
OMISSIONS: Final[tuple[tuple[str, dict[str, Any]], ...]] = (
    ("P = 0", {"p": 0.0}),
    ("P = 0.002", {"p": 0.002}),
    ("P = 1/2, 0, 0", {"p": (0.5, 0.0, 0.0)}),
    ("eps = 1e-6", {"eps": 1e-6}),
    ("z = 1", {"z": 1.0}),
)


@dataclass(frozen=True)
class Row:
    """One setting on one image."""

    group: Group
    setting: str
    mean: float
    """Of the absolute error, in grey levels of 255."""
    p999: float
    """99.9th percentile."""
    most: float
    bound: float | None
    """On `most`, where something is left out."""
    milliseconds: float | None
    """Median of a whole image with its statistics; None where the setting is not built into the product."""


def accuracy(image: NDArray[np.uint8], repeats: int = 7) -> Iterator[Row]:
    """Rows for an RGB image.

    "subsample", "nearest" and "scales" are measured against float64 without subsampling, with three scales;
    "arithmetic" against float64 with the same subsampling. Bytes are compared with bytes, floats and 16 bits
    unrounded. "left out" compares what `omit_below` leaves out with "kept in", the row after it.
    """
    truth = _reference(image, replace(EXACT, subsample=1))
    for subsample in (1, 2, 4, 8):
        params = replace(EXACT, subsample=subsample)
        yield _row("subsample", f"s = {subsample}", image, params, truth, repeats)
    for subsample in (2, 4, 8):
        error = np.abs(_nearest(image, subsample).astype(np.float64) - np.rint(truth))
        yield _summary("nearest", f"s = {subsample}", error, None, None)
    for radii in SUBSETS:
        params = replace(EXACT, radii=radii)
        yield _row("scales", " + ".join(map(str, radii)), image, params, truth, repeats)
    yield from _arithmetic(image, repeats)
    yield from _omissions(image, repeats)


def _arithmetic(image: NDArray[np.uint8], repeats: int) -> Iterator[Row]:
    truth = _reference(image, EXACT)
    kinds: dict[str, AnyImage] = {
        "uint8, tables": image,
        "uint16, direct powers": image.astype(np.uint16) * np.uint16(257),
        "float32, direct powers": image / np.float32(255),
        "float64, direct powers": image / 255,
    }
    for name, same in kinds.items():
        yield _row("arithmetic", name, same, EXACT, truth, repeats)


def _omissions(image: NDArray[np.uint8], repeats: int) -> Iterator[Row]:
    """On float32, where an error is not hidden by rounding."""
    pixels = image / np.float32(255)
    for name, change in OMISSIONS:
        params = replace(EnhanceParams(), **change)
        whole, whole_ms, _ = _timed(pixels, replace(params, omit_below=0.0), repeats)
        lean, lean_ms, bound = _timed(pixels, params, repeats)
        error = 255 * np.abs(lean.astype(np.float64) - whole)
        yield _summary("left out", name, error, bound, lean_ms)
        yield _summary("kept in", name, np.zeros_like(error), None, whole_ms)


def _row(
    group: Group,
    setting: str,
    image: AnyImage,
    params: EnhanceParams,
    truth: NDArray[np.float64],
    repeats: int,
) -> Row:
    result, milliseconds, _ = _timed(image, params, repeats)
    levels = result.astype(np.float64) * (255 / full_scale(result.dtype))
    error = np.abs(levels - (np.rint(truth) if result.dtype == np.uint8 else truth))
    return _summary(group, setting, error, None, milliseconds)


def _timed(image: AnyImage, params: EnhanceParams, repeats: int) -> tuple[AnyImage, float, float]:
    """The result, median milliseconds of a stream of such images, and the bound on what is left out."""
    enhancer, taken = Enhancer(), []
    enhancer.show(image)
    result = enhancer.enhance(params)
    for _ in range(repeats):
        start = perf_counter()
        enhancer.show(image)
        result = enhancer.enhance(params)
        taken.append(1000 * (perf_counter() - start))
    return result.image, median(taken), sum(omission.error for omission in result.omitted)


def _nearest(image: NDArray[np.uint8], subsample: int) -> AnyImage:
    """With V decimated to the middle pixel of each block; the first pass leaves the block's mean."""
    enhancer = Enhancer()
    enhancer.show(image)
    enhancer._surveyed(subsample).low[:] = _decimated(image, subsample)
    return enhancer.enhance(replace(EXACT, subsample=subsample)).image


def _decimated(image: NDArray[np.uint8], subsample: int) -> NDArray[np.float32]:
    value = image.max(axis=2)
    rows, columns = (
        np.minimum(np.arange(-(-size // subsample)) * subsample + subsample // 2, size - 1)
        for size in value.shape
    )
    return np.asarray(value[np.ix_(rows, columns)] / np.float32(255), dtype=np.float32)


def _reference(image: NDArray[np.uint8], params: EnhanceParams) -> NDArray[np.float64]:
    """In grey levels, not rounded."""
    return 255 * enhance_reference(image, params)[0]


def _summary(
    group: Group, setting: str, error: NDArray[np.float64], bound: float | None, ms: float | None
) -> Row:
    return Row(
        group=group,
        setting=setting,
        mean=float(error.mean()),
        p999=float(np.quantile(error, 0.999)),
        most=float(error.max()),
        bound=bound,
        milliseconds=ms,
    )
