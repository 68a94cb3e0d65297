"""Stiff and extreme cases of every equation: what float32 makes of them, measured against a bar."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Any, Final, get_args, get_type_hints

import numpy as np
from annotated_types import Interval
from numpy.typing import NDArray

from enhance import detail
from enhance.brightness import brighten
from enhance.guided_filter import Grids, Window, WindowModels
from enhance.image import AnyImage, ImageError, full_scale
from enhance.params import EnhanceParams, PForm
from enhance.pipeline import enhance
from enhance.reference import enhance_reference, window_mean

Image = NDArray[np.float64]
WHOLE: Final = EnhanceParams(omit_below=0.0)
PLAIN: Final = EnhanceParams(omit_below=0.0, keep_black=False)


@dataclass(frozen=True)
class Row:
    """One hazard: what was measured, and what it may be at most."""

    hazard: str
    case: str
    measured: float
    bar: float
    unit: str = "grey levels"
    done: str = ""
    """What the product does there, where that is more than to compute."""

    @property
    def passed(self) -> bool:
        """False also for NaN."""
        return self.measured <= self.bar


def stability(image: NDArray[np.uint8]) -> Iterator[Row]:
    """All rows; `image` (H, W, 3) is ordinary tissue for the cases that need some."""
    for part in (_precision, _ends, _exponents, _constants, _sizes, _filter, _saturation, _black, _types):
        yield from part(image)


def _precision(image: NDArray[np.uint8]) -> Iterator[Row]:
    hazard = "float32 against float64"
    yield Row(hazard, "float image, most", _error(image / 255, WHOLE), 0.001)
    result, exact = enhance(image, WHOLE).image, 255 * enhance_reference(image, WHOLE)[0]
    apart = np.abs(result - np.rint(exact))
    yield Row(hazard, "bytes, most", float(apart.max()), 1)
    yield Row(hazard, "bytes that differ", float(np.mean(apart > 0)), 1e-4, "share")


def _ends(image: NDArray[np.uint8]) -> Iterator[Row]:
    """Every parameter at both ends of its range, as declared; then all at their worst at once."""
    pixels = image / 255
    for name, low, high in ranges():
        for end in (low, high):
            change: dict[str, Any] = {name: (end,) if name == "radii" else end}
            params = replace(WHOLE, **change)
            yield Row("ends of the ranges", f"{name} = {end:g}", _error(pixels, params), 0.001)
    worst = replace(PLAIN, z=1.0, p=4.0, eps=1e-6, radii=(1, 512), d_factor=1e-9)
    yield Row("ends of the ranges", "z 1, P 4, eps 1e-6, d-factor 1e-9", _error(pixels, worst), 0.005)


def ranges() -> Iterator[tuple[str, float, float]]:
    """Name and ends of each numeric parameter of the enhancement, from its declaration."""
    hints = get_type_hints(EnhanceParams, include_extras=True)
    for field in fields(EnhanceParams):
        interval = _interval(hints[field.name])
        if interval is not None and field.name != "omit_below":
            assert isinstance(interval.ge, float | int)
            assert isinstance(interval.le, float | int)
            yield field.name, interval.ge, interval.le


def _interval(hint: Any) -> Interval | None:
    """The first that the annotation, or what it is made of, carries."""
    for part in get_args(hint):
        if isinstance(part, Interval):
            return part
        found = _interval(part)
        if found is not None:
            return found
    return None


def _exponents(image: NDArray[np.uint8]) -> Iterator[Row]:
    """The jumps of Eq 9 as printed, and without; in P, and in a faint picture on either side."""
    faint = 0.5 + (image[..., 1] / 255 - 0.5) * 0.05
    jumps: dict[PForm, tuple[float, float]] = {
        "literal": (23 / 13 - 7 / 4, 7 / 13 - 1 / 2),
        "continuous": (0, 0),
    }
    for form, bars in jumps.items():
        for sigma, bar in zip((2.0, 10.0), bars, strict=True):
            below, above = (detail.exponent(sigma + side, form) for side in (-1e-6, 1e-6))
            yield Row("jumps of P", f"{form}, sigma = {sigma:g}", abs(above - below), bar + 1e-6, "P")
            first, second = (enhance(faint, replace(WHOLE, p=p)).image for p in (below, above))
            apart = 255 * float(np.abs(first - second).max())
            yield Row("jumps of P", f"{form}, sigma = {sigma:g}, picture", apart, 0.5 if bar else 1e-3)


def _constants(_: NDArray[np.uint8]) -> Iterator[Row]:
    for level in (0, 1, 50, 128, 254, 255):
        result = enhance(np.full((20, 30), level, np.uint8), PLAIN)
        expected = 255 * brighten(np.array([level / 255]), result.statistics.z)[0]
        apart = float(np.abs(result.image - expected).max())
        yield Row("constant images", f"grey {level}, against Eq 1", apart, 0.5)
        yield Row("constant images", f"grey {level}, sigma", max(result.statistics.sigmas), 1e-3)
    black, white = np.zeros((20, 30, 3), np.uint8), np.full((20, 30, 3), 255, np.uint8)
    yield Row("constant images", "black stays black", float(enhance(black, WHOLE).image.max()), 0)
    yield Row("constant images", "white stays white", 255 - float(enhance(white, WHOLE).image.min()), 0)


def _sizes(image: NDArray[np.uint8]) -> Iterator[Row]:
    rows, columns = image.shape[0] // 2, image.shape[1] // 2
    cases = {
        "one pixel": (1, 1),
        "one row": (1, 60),
        "one column": (60, 1),
        "two pixels": (2, 1),
        "50 x 50": (50, 50),
    }
    for name, (height, width) in cases.items():
        part = image[rows : rows + height, columns : columns + width] / 255
        for subsample in (1, 2, 8):
            params = replace(WHOLE, subsample=subsample, radii=(4, 512))
            yield Row("small images", f"{name}, s = {subsample}, r = 512", _error(part, params), 0.001)


def _filter(_: NDArray[np.uint8]) -> Iterator[Row]:
    """Variance as a difference of large numbers: bright, nearly flat, and large."""
    noise = np.random.default_rng(5).normal(0, 1e-3, (2, 600, 700))
    low = np.stack((np.clip(0.98 + noise[0], 0, 1), noise[1] ** 2)).astype(np.float32)
    exact = low.astype(np.float64)
    grids = Grids(low, np.empty((2, 0, 0), np.float32))
    for radius in (2, 32, 300):
        for part in (0.0, 0.625):
            one, reach = Window(1, False, radius, part, 1e-6), radius + part
            a, b = WindowModels().of(grids, (one,), (True,)).fine[0]
            mean = window_mean(exact[0], reach)
            square = window_mean((exact[0] - 0.98) ** 2 + exact[1], reach)
            variance = square - (mean - 0.98) ** 2
            slope = variance / (variance + 1e-6)
            offset = window_mean((1 - slope) * mean, reach)
            case = f"r = {reach:g}"
            yield Row("cancelling variance", f"a, {case}", _most(a, window_mean(slope, reach)), 2e-5, "of 1")
            yield Row("cancelling variance", f"b, {case}", _most(b, offset), 1e-6, "of 1")
    for deviation in (1e-5, 1e-4, 1e-3):
        flat = (0.98 + np.random.default_rng(7).normal(0, deviation, (96, 128))).astype(np.float32)
        error = _error(flat, replace(WHOLE, eps=1e-6, p=4.0))
        yield Row("cancelling variance", f"bright noise of {deviation:g}, P 4, eps 1e-6", error, 0.001)


def _saturation(image: NDArray[np.uint8]) -> Iterator[Row]:
    """Means of S near 0 and 1, where d of Eq 12 vanishes and explodes."""
    for mean in (0.0, 1e-6, 0.5, 0.999, 0.99999, 1.0):
        for k in (1e-6, 1.0, 4.0):
            measured = replace(enhance(image, WHOLE).statistics, saturation_mean=mean)
            params = replace(WHOLE, d_factor=k)
            result = enhance(image / 255, params, statistics=measured).image
            exact, _ = enhance_reference(image / 255, params, statistics=measured)
            apart = 255 * _most(result, exact)
            yield Row("mean saturation", f"S_m = {mean:g}, d-factor {k:g}", apart, 0.001)
    grey = np.repeat(image[..., :1], 3, axis=2)
    spread = float(np.ptp(enhance(grey, WHOLE).image, axis=2).max())
    yield Row("mean saturation", "grey stays grey", spread, 0)


def _black(_: NDArray[np.uint8]) -> Iterator[Row]:
    """One code of sensor noise in the dark, at z = 0: Eq 1 makes 32 of it, with `keep_black` at most 7."""
    codes = np.arange(64, dtype=np.uint8)[None]
    for name, params, bar in (("Eq 1", PLAIN, 32.0), ("with keep_black", WHOLE, 7.5)):
        steps = np.diff(enhance(codes, replace(params, z=0.0, p=0.0)).image.astype(int)[0])
        yield Row("noise at black", f"largest step of one code, {name}", float(steps.max()), bar)
        yield Row("noise at black", f"order kept, {name}", float(-steps.min()), 0)
    dark = np.random.default_rng(6).integers(0, 3, (80, 90), dtype=np.uint8)
    noise = float(dark.std())
    for name, params, bar in (("Eq 1", PLAIN, 32 * noise), ("with keep_black", WHOLE, 3 * noise)):
        spread = float(enhance(dark, replace(params, z=0.0, p=0.0)).image.std())
        yield Row("noise at black", f"deviation of noise of {noise:.2f}, {name}", spread, bar)
    edge = np.zeros((40, 60, 3), np.uint8)
    edge[:, 30:] = 200
    whitest = float(enhance(edge, PLAIN).image[:, :30].max())
    yield Row("noise at black", "black beside tissue stays below Eq 1", whitest, 51)


def _types(image: NDArray[np.uint8]) -> Iterator[Row]:
    for value in (1e-38, 1e-20, 1e-6):
        tiny = np.zeros((20, 30, 3))
        tiny[5:15, 5:15] = value, value / 2, 0
        result = enhance(tiny.astype(np.float32), replace(PLAIN, z=1.0, p=4.0)).image
        yield Row(
            "types", f"floats of {value:g}: not finite", float(np.sum(~np.isfinite(result))), 0, "values"
        )
    wide = enhance(image.astype(np.uint16) * np.uint16(257), WHOLE).image / 257
    yield Row("types", "uint16 against uint8", _most(wide, enhance(image, WHOLE).image), 0.51)
    for name, bad in (("NaN", np.nan), ("infinity", np.inf), ("2.0", 2.0), ("-0.1", -0.1)):
        spoilt = image / 255
        spoilt[3, 4, 1] = bad
        done = "refused in a line that names the value and its place"
        yield Row("types", f"{name} is not refused", float(not _refused(spoilt)), 0, "cases", done)


def _refused(image: AnyImage) -> bool:
    try:
        enhance(image)
    except ImageError:
        return True
    return False


def _error(pixels: AnyImage, params: EnhanceParams) -> float:
    """Largest difference to float64 in grey levels, with the same statistics."""
    result = enhance(pixels, params)
    exact, _ = enhance_reference(pixels, params, statistics=result.statistics)
    return 255 * _most(result.image / full_scale(result.image.dtype), exact)


def _most(one: AnyImage, other: AnyImage) -> float:
    return float(np.abs(one.astype(np.float64) - other).max())
