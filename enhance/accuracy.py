"""Error against run time: what each approximation costs in grey levels and saves in time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter
from typing import Any, Final, Literal, Self

import numpy as np
from numpy.typing import NDArray

from enhance.enhancer import Enhancer
from enhance.guided_filter import Window, Windows, window, window_on
from enhance.image import AnyImage, full_scale
from enhance.params import EnhanceParams
from enhance.pipeline import enhance
from enhance.reference import enhance_reference
from enhance.result import Omission

Group = Literal["subsample", "sampling", "scales", "both", "arithmetic", "left out", "kept in"]
EXACT: Final = EnhanceParams(omit_below=0.0)
SUBSETS: Final = ((4,), (16,), (64,), (4, 16), (4, 64), (16, 64), (4, 16, 64))


@dataclass(frozen=True)
class Pair:
    """Settings that let something be left out, and what keeps it in though it changes nothing."""

    name: str
    lean: EnhanceParams
    whole: EnhanceParams

    @classmethod
    def of(cls, name: str, change: dict[str, Any], kept: dict[str, Any]) -> Self:
        """`change` from the defaults, and what `kept` changes in that."""
        lean = replace(EnhanceParams(), **change)
        return cls(name, lean, replace(lean, omit_below=0.0, **kept))


PAIRS: Final = (
    Pair.of("P = 0", {"p": 0.0}, {"p": 1e-30}),
    Pair.of("P = 1/2, 0, 0", {"p": (0.5, 0.0, 0.0)}, {"p": (0.5, 1e-30, 1e-30)}),
    Pair.of("P = 0.001", {"p": 0.001}, {}),
    Pair.of("P = 0.002", {"p": 0.002}, {}),
    Pair.of("P = 1/2, 1/2, 0.003", {"p": (0.5, 0.5, 0.003)}, {}),
    Pair.of("P = 1/2", {"p": 0.5}, {}),
    Pair.of("z = 1", {"z": 1.0}, {"z": 1 - 1e-7}),
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
    spread: float | None = None
    """Half of the distance between the quartiles of these milliseconds."""
    omitted: tuple[Omission, ...] = ()
    """What the product does without on this image, with this setting."""


def named(params: EnhanceParams) -> tuple[Group, str]:
    """Group and setting under which the windows of these parameters are among the rows, if they are."""
    radii = " + ".join(map(str, params.radii))
    if params.radii == EXACT.radii:
        return "subsample", f"s = {params.subsample}"
    if params.subsample == EXACT.subsample:
        return "scales", radii
    return "both", f"{radii}, s = {params.subsample}"


def accuracy(image: NDArray[np.uint8], repeats: int = 7) -> Iterator[Row]:
    """Rows for an RGB image.

    "subsample", "sampling", "scales" and "both" are measured against float64 without subsampling, with
    three scales; "arithmetic" against float64 with the same subsampling. Bytes are compared with bytes,
    floats and 16 bits unrounded. "sampling" is what the product does not do: all windows on one grid; widths
    rounded to whole pixels of it; variances of block means; V decimated. "left out" compares what
    `omit_below` leaves out with "kept in", the row after it.
    """
    yield from _timed([*_against_three_scales(image), *_arithmetic(image), *_omissions(image)], repeats)


def omissions(image: NDArray[np.uint8], repeats: int) -> list[tuple[Pair, Row, Row]]:
    """Of each of PAIRS what is left out, and the same with it kept in."""
    rows = list(_timed(_omissions(image), repeats))
    return list(zip(PAIRS, rows[::2], rows[1::2], strict=True))


@dataclass(frozen=True, eq=False)
class _Case:
    """A setting whose time is still to be taken."""

    group: Group
    setting: str
    error: NDArray[np.float64]
    work: Callable[[], object] | None
    """None where the setting is not built into the product."""
    omitted: tuple[Omission, ...] | None = None
    """None where nothing may be left out."""


def _against_three_scales(image: NDArray[np.uint8]) -> Iterator[_Case]:
    truth = _reference(image, replace(EXACT, subsample=1))
    for subsample in (1, 2, 4, 8):
        params = replace(EXACT, subsample=subsample)
        yield _case(*named(params), image, params, truth)
    yield from _samplings(image, truth)
    for radii in SUBSETS:
        yield _case("scales", " + ".join(map(str, radii)), image, replace(EXACT, radii=radii), truth)
    for subsample in (4, 8):
        for radii in SUBSETS[:-1]:
            params = replace(EXACT, radii=radii, subsample=subsample)
            yield _case(*named(params), image, params, truth)


def _samplings(image: NDArray[np.uint8], truth: NDArray[np.float64]) -> Iterator[_Case]:
    for subsample in (2, 4, 8):
        params = replace(EXACT, subsample=subsample)
        name = f"s = {subsample}, one grid"
        yield _case("sampling", name, image, params, truth, _Sampled(_on_one_grid))
    yield _case("sampling", "s = 2, rounded widths", image, EXACT, truth, _Sampled(_rounded))
    changed = {"s = 2, means alone": _coarser(image, 2, decimated=False)}
    changed |= {f"s = {s}, nearest": _coarser(image, s, decimated=True) for s in (2, 4, 8)}
    for name, result in changed.items():
        yield _Case("sampling", name, np.abs(result.astype(np.float64) - np.rint(truth)), None)


def _arithmetic(image: NDArray[np.uint8]) -> Iterator[_Case]:
    truth = _reference(image, EXACT)
    kinds: dict[str, AnyImage] = {
        "uint8, tables": image,
        "uint16, direct powers": image.astype(np.uint16) * np.uint16(257),
        "float32, direct powers": image / np.float32(255),
        "float64, direct powers": image / 255,
    }
    for name, same in kinds.items():
        yield _case("arithmetic", name, same, EXACT, truth)


def _omissions(image: NDArray[np.uint8]) -> Iterator[_Case]:
    """Errors are on float32, where rounding does not hide them; times on bytes."""
    pixels = image / np.float32(255)
    for pair in PAIRS:
        lean, whole = enhance(pixels, pair.lean), enhance(pixels, pair.whole)
        error = 255 * np.abs(lean.image.astype(np.float64) - whole.image)
        work, kept = (partial(_frame, Enhancer(), image, params) for params in (pair.lean, pair.whole))
        yield _Case("left out", pair.name, error, work, lean.omitted)
        yield _Case("kept in", pair.name, np.zeros_like(error), kept)


def _case(
    group: Group,
    setting: str,
    image: AnyImage,
    params: EnhanceParams,
    truth: NDArray[np.float64],
    enhancer: Enhancer | None = None,
) -> _Case:
    work = partial(_frame, enhancer or Enhancer(), image, params)
    result = work()
    levels = result.astype(np.float64) * (255 / full_scale(result.dtype))
    error = np.abs(levels - (np.rint(truth) if result.dtype == np.uint8 else truth))
    return _Case(group, setting, error, work)


def _frame(enhancer: Enhancer, image: AnyImage, params: EnhanceParams) -> AnyImage:
    """The next of a stream of such images."""
    enhancer.show(image)
    return enhancer.enhance(params).image


def _timed(cases: Iterable[_Case], repeats: int) -> Iterator[Row]:
    known = list(cases)
    timed = iter(_laps([case.work for case in known if case.work is not None], repeats))
    for case in known:
        yield _summary(case, None if case.work is None else next(timed))


def _laps(works: Sequence[Callable[[], object]], repeats: int) -> list[NDArray[np.float64]]:
    """Milliseconds of each; they take turns, so that a busy machine slows them alike."""
    taken = np.empty((repeats + 1, len(works)))
    for row in taken:
        for index, work in enumerate(works):
            start = perf_counter()
            work()
            row[index] = 1000 * (perf_counter() - start)
    return list(taken[1:].T)


class _Sampled(Enhancer):
    """With other windows than the product's."""

    def __init__(self, window: Callable[[int, float, int], Window]) -> None:
        super().__init__()
        self._window = window

    def _windows(self, params: EnhanceParams) -> Windows:
        return tuple(self._window(radius, params.eps, params.subsample) for radius in params.radii)


def _on_one_grid(radius: int, eps: float, subsample: int) -> Window:
    return window_on(radius, eps, subsample, coarse=False)


def _rounded(radius: int, eps: float, subsample: int) -> Window:
    """Of r / s whole pixels on each side, halves up."""
    one = window(radius, eps, subsample)
    return one._replace(whole=max(1, math.floor(one.whole + one.part + 0.5)), part=0.0)


def _coarser(image: NDArray[np.uint8], subsample: int, *, decimated: bool) -> AnyImage:
    """Without the variance of blocks; `decimated`: with the middle pixel of each in place of its mean."""
    enhancer = Enhancer()
    enhancer.show(image)
    enhancer._look_within(None)
    for plane, size in zip(enhancer._surveyed(subsample).low, (subsample, 2 * subsample), strict=True):
        plane[1] = 0
        if decimated:
            plane[0] = _decimated(image, size)
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


def _summary(case: _Case, laps: NDArray[np.float64] | None) -> Row:
    quartiles = None if laps is None else np.percentile(laps, (25, 50, 75))
    return Row(
        group=case.group,
        setting=case.setting,
        mean=float(case.error.mean()),
        p999=float(np.quantile(case.error, 0.999)),
        most=float(case.error.max()),
        bound=None if case.omitted is None else sum(omission.error for omission in case.omitted),
        milliseconds=None if quartiles is None else float(quartiles[1]),
        spread=None if quartiles is None else float(quartiles[2] - quartiles[0]) / 2,
        omitted=case.omitted or (),
    )
