"""Stiff and extreme cases of every equation: what float32 makes of them, measured against a bar."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from typing import Any, Final, get_args, get_type_hints

import cv2
import numpy as np
from annotated_types import Interval
from numpy.typing import NDArray

from enhance import detail
from enhance.field_tracker import FieldTracker
from enhance.guided_filter import Grids, Window, WindowModels
from enhance.image import AnyImage, ImageError, full_scale, read_picture
from enhance.noise import chroma_noise_gain, noise_gain
from enhance.params import EnhanceParams, PForm
from enhance.pipeline import enhance
from enhance.reference import enhance_reference, window_mean
from enhance.shown import found_in
from enhance.stability_row import Row
from enhance.stability_vessel import extremes
from enhance.vessel import enhance_vessels

WHOLE: Final = EnhanceParams(omit_below=0.0)
PLAIN: Final = EnhanceParams(omit_below=0.0, keep_black=False)


def stability(image: NDArray[np.uint8]) -> Iterator[Row]:
    """All rows; `image` (H, W, 3) is ordinary tissue for the cases that need some."""
    for part in PARTS.values():
        yield from part(image)


def _precision(image: NDArray[np.uint8]) -> Iterator[Row]:
    hazard = "float32 against float64"
    yield Row(hazard, "float image, most", _error(image / 255, WHOLE), 0.001)


def _bytes(image: NDArray[np.uint8]) -> Iterator[Row]:
    hazard = "float32 against float64"
    result, exact = enhance(image, WHOLE).image, 255 * enhance_reference(image, WHOLE)[0]
    apart = np.abs(result - np.rint(exact))
    yield Row(hazard, "bytes, most", float(apart.max()), 1)
    yield Row(hazard, "bytes that differ", float(np.mean(apart > 0)), 1e-4, "share")


def _statistics(image: NDArray[np.uint8]) -> Iterator[Row]:
    """What the equations take from the whole image, and other rows hand to both sides."""
    hazard = "statistics against float64"
    left = np.zeros(image.shape[:2], bool)
    left[:, : image.shape[1] // 2] = True
    faint = np.rint(127 + 0.1 * (image - 127.0)).astype(np.uint8)
    cases: dict[str, tuple[AnyImage, NDArray[np.bool_] | None]] = {
        "bytes": (image, None),
        "its left half": (image, left),
        "faint bytes": (faint, None),
        "faint floats": (faint / 255, None),
    }
    for name, (pixels, mask) in cases.items():
        got = enhance(pixels, WHOLE, tissue_mask=mask).statistics
        _, exact = enhance_reference(pixels, WHOLE, tissue_mask=mask)
        yield Row(hazard, f"{name}, L", abs(got.level - exact.level), 0)
        yield Row(hazard, f"{name}, z", abs(got.z - exact.z), 1e-12, "z")
        chroma = abs(got.saturation_mean - exact.saturation_mean)
        yield Row(hazard, f"{name}, S_m", chroma, 1e-6, "of 1")
        red = [np.array(each.redness, float) for each in (got, exact)]
        yield Row(hazard, f"{name}, redness", _most(*red), 1e-6, "of V")
        yield Row(hazard, f"{name}, sigma", _most(np.array(got.sigmas), np.array(exact.sigmas)), 1e-3)
        yield Row(hazard, f"{name}, P", _most(np.array(got.p), np.array(exact.p)), 1e-4, "P")


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
    """The jumps of Eq 9 are those that are printed, or none; and a faint picture on either side of them."""
    hazard, faint = "jumps of P", 0.5 + (image[..., 1] / 255 - 0.5) * 0.05
    printed: dict[PForm, tuple[float, float]] = {
        "literal": (23 / 13 - 7 / 4, 7 / 13 - 1 / 2),
        "continuous": (0, 0),
    }
    sigmas = np.linspace(0, 127.5, 1021)
    for form, jumps in printed.items():
        ends = (2.0, 10.0) if form == "literal" else (2.125, 10.25)
        middle = (27 - 2 * sigmas) / 13
        exact = np.where(sigmas <= ends[0], 7 / 4, np.where(sigmas < ends[1], middle, 1 / 2))
        found = np.array([detail.exponent(sigma, form) for sigma in sigmas.tolist()])
        yield Row(hazard, f"{form}, P at every sigma", _most(found, exact), 1e-12, "P")
        for sigma, jump in zip((2.0, 10.0), jumps, strict=True):
            case = f"{form}, sigma = {sigma:g}"
            below, above = (detail.exponent(sigma + side, form) for side in (-1e-6, 1e-6))
            yield Row(hazard, case, abs(abs(above - below) - jump), 1e-6, "P, off the printed jump")
            sides = [replace(WHOLE, p=p) for p in (below, above)]
            yield Row(hazard, f"{case}, image", float(np.max([_error(faint, side) for side in sides])), 0.001)
            if jump:
                first, second = (enhance(faint, side).image for side in sides)
                yield Row(hazard, f"{case}, jump of the image", 255 * _most(first, second), 0.5)


def _constants(image: NDArray[np.uint8]) -> Iterator[Row]:
    for level in (0, 1, 50, 128, 254, 255):
        given = np.full((20, 30), level, np.uint8)
        result, exact = enhance(given, PLAIN), enhance_reference(given, PLAIN)[0]
        yield Row("constant images", f"grey {level}, against Eq 1", _most(result.image, 255 * exact), 0.5)
        sigma = _most(np.array(result.statistics.sigmas), 0.0)
        if level > 0:  # of black it is nothing else
            yield Row("constant images", f"grey {level}, sigma", sigma, 1e-3)
    black, white = np.zeros((20, 30, 3), np.uint8), np.full((20, 30, 3), 255, np.uint8)
    yield Row("constant images", "black stays black", float(enhance(black, WHOLE).image.max()), 0)
    yield Row("constant images", "white stays white", 255 - float(enhance(white, WHOLE).image.min()), 0)
    grey = np.repeat(image[..., :1], 3, axis=2)
    spread = float(np.ptp(enhance(grey, WHOLE).image, axis=2).max())
    yield Row("mean saturation", "grey stays grey", spread, 0)


def _hues(image: NDArray[np.uint8]) -> Iterator[Row]:
    """Tissue is red: each of the other colours as the largest, and all hues."""
    for name, order in (("green", (1, 0, 2)), ("blue", (2, 1, 0))):
        yield Row("other hues", f"{name} is the largest", _error(image[..., order] / 255, WHOLE), 0.001)
    noise = np.random.default_rng(3).uniform(0, 1, (40, 50, 3))
    yield Row("other hues", "every hue and saturation", _error(noise, WHOLE), 0.001)


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
        error = _error(tiny.astype(np.float32), replace(PLAIN, z=1.0, p=4.0))
        yield Row("types", f"floats of {value:g}", error, 0.001)
    wide = enhance(image.astype(np.uint16) * np.uint16(257), WHOLE).image / 257
    yield Row("types", "uint16 against uint8", _most(wide, enhance(image, WHOLE).image), 0.51)
    for name, bad, line in (
        ("NaN", np.nan, "without NaN, got 1 of .* the first at row 3, column 4, channel 1 "),
        ("infinity", np.inf, r"in \[0, 1\], got .* to inf;"),
        ("2.0", 2.0, r"in \[0, 1\], got .* to 2;"),
        ("-0.1", -0.1, r"in \[0, 1\], got -0\.1 to "),
    ):
        spoilt = image / 255
        spoilt[3, 4, 1] = bad
        done = "refused in a line that names the value, and the place of NaN"
        yield Row("types", f"{name} is not refused", float(not _refused(spoilt, line)), 0, "cases", done)


def _fields(image: NDArray[np.uint8]) -> Iterator[Row]:
    """The field of view, found in well lit tissue with a surround and in pictures without one."""
    hazard = "field of view"
    for case, (pixels, field) in _surrounded(np.maximum(image, 90)).items():
        found = found_in(read_picture(pixels)).mask()
        away = cv2.distanceTransform((~found).astype(np.uint8), cv2.DIST_L2, 5)
        missed = float(np.max(away, where=field & ~found, initial=0))
        yield Row(hazard, f"{case}, tissue left out, farthest from the field", missed, 8, "pixels")
        if field.all():
            continue
        taken = float(np.mean(found & ~field))
        yield Row(hazard, f"{case}, surround that is taken in", taken, 0, "share")
        for name, run in (("paper", enhance), ("vessel", enhance_vessels)):
            changed = float(np.mean(run(pixels).image[~found] != pixels[~found])) if not found.all() else 1.0
            yield Row(hazard, f"{case}, changed by {name} beyond the field", changed, 0, "share")
    tracker, disc = FieldTracker(), _disc(image.shape[:2], 0.5, 0.4)
    noise, fields = np.random.default_rng(9), set()
    for step in range(24):
        moved = np.roll(disc, step % 3 - 1, axis=1)
        fields.add(tracker.follow(read_picture(_within(image, moved, noise))))
    yield Row(hazard, "circle that trembles, changes of the mask", float(len(fields) - 1), 0, "changes")
    tracker, left = FieldTracker(), 0.0
    for step in range(40):
        moved = np.roll(disc, (step - 20) * image.shape[1] // 320, axis=1)
        found = tracker.follow(read_picture(_within(image, moved, noise))).mask()
        left = max(left, float(np.mean(~found[moved])))
    yield Row(hazard, "circle that moves, tissue left out", left, 0.2, "share")


def _surrounded(image: NDArray[np.uint8]) -> dict[str, tuple[NDArray[np.uint8], NDArray[np.bool_]]]:
    """Pictures, and what is field in them."""
    shape, noise = image.shape[:2], np.random.default_rng(8)
    whole, third, half = (np.ones(shape, bool) for _ in range(3))
    third[:, : shape[1] // 3] = half[:, : shape[1] // 2] = False
    round_view, beyond, aside = (_disc(shape, *at) for at in ((0.5, 0.42), (0.5, 0.62), (0.62, 0.48)))
    cut = round_view & (np.arange(shape[1]) < 0.62 * shape[1])
    eyes = _disc(shape, 0.26, 0.28) | _disc(shape, 0.74, 0.28)
    point = np.zeros_like(image)
    point[shape[0] // 2, shape[1] // 2] = 200
    texts = _within(image, round_view, noise)
    texts[2:6, 3 : shape[1] // 8] = 230
    boxes = texts.copy()
    boxes[-shape[0] // 6 : -4, 4 : shape[1] // 6] = (40, 90, 160)
    boxes[4 : shape[0] // 7, -shape[1] // 6 : -4] = 120
    boxes[6 : shape[0] // 7 - 2, -shape[1] // 6 + 2 : -6] = 0
    black, white = np.zeros_like(image), np.full_like(image, 255)
    grey = np.repeat(_within(image, round_view, noise)[..., 1:2], 3, axis=2)
    row = np.any([_disc(shape, at, 0.147 * shape[1] / shape[0]) for at in (0.2, 0.5, 0.8)], axis=0)
    depth = cv2.distanceTransform(beyond.astype(np.uint8), cv2.DIST_L2, 5)[..., None]
    dim = (image * (1 - 0.9 * (1 - depth / depth.max()) ** 3)).astype(np.uint8)
    page, shown, figure = white.copy(), np.s_[shape[0] // 8 :, shape[1] // 8 : -shape[1] // 8], ~whole
    figure[shown] = _disc(figure[shown].shape, 0.5, 0.42)
    page[shown] = _within(image[shown], figure[shown], noise)
    return {
        "all black": (black, whole),
        "all white": (white, whole),
        "one pixel of tissue": (point, whole),
        "noise alone": (noise.integers(0, 6, image.shape, dtype=np.uint8), whole),
        "no surround": (image, whole),
        "a third dark": (_within(image, third, noise), third),
        "half dark": (_within(image, half, noise), half),
        "circle": (_within(image, round_view, noise), round_view),
        "circle larger than the image": (_within(image, beyond, noise), beyond),
        "circle beside the middle": (_within(image, aside, noise), aside),
        "circle with a straight side": (_within(image, cut, noise), cut),
        "two circles": (_within(image, eyes, noise), eyes),
        "text in the surround": (texts, round_view),
        "text and boxes in the surround": (boxes, round_view),
        "grey": (grey, round_view),
        "three circles side by side": (_within(image, row, noise), row),
        "circle larger than the image, dim at its rim": (_within(dim, beyond, noise), beyond),
        "circle in the dark on a white page": (page, figure),
    }


def _disc(shape: tuple[int, int], across: float, radius: float) -> NDArray[np.bool_]:
    """Middle and radius as shares of width and height."""
    y, x = np.mgrid[: shape[0], : shape[1]] + 0.5
    return np.asarray(np.hypot(x - across * shape[1], y - shape[0] / 2) < radius * shape[0])


def _within(
    image: NDArray[np.uint8], field: NDArray[np.bool_], noise: np.random.Generator
) -> NDArray[np.uint8]:
    """The picture in a surround of a few grey levels."""
    return np.where(field[..., None], image, noise.integers(0, 5, image.shape, dtype=np.uint8))


def _noise_gains(image: NDArray[np.uint8]) -> Iterator[Row]:
    """Of noise that is known: scaled, beside what is clipped, and of colours below the rounding to 8 bits."""
    hazard, half = "noise gains", image.shape[1] // 2
    light = np.linspace(0, 0.2, image.shape[1])[:, None]
    for name, gain in (("noise", noise_gain), ("chroma noise", chroma_noise_gain)):
        scaled = 0.7 * (image / 255) + light
        yield Row(
            hazard, f"{name}, 0.7 times and lit otherwise", abs(gain(scaled, image) - 0.7), 1e-4, "of 1"
        )
        for case, level in (("white", 1), ("black", 0)):
            scaled[:, half:] = level
            yield Row(hazard, f"{name}, half {case}", abs(gain(scaled, image) - 0.7), 1e-4, "of 1")
    rng = np.random.default_rng(11)
    grey = rng.normal(120, 1.5, (240, 320))
    red, blue = (cv2.resize(rng.normal(0, 0.8, (120, 160)), (320, 240)) for _ in range(2))
    before, after = (
        np.rint(np.stack((grey + k * red, grey, grey + k * blue), axis=2)).astype(np.uint8) for k in (1, 2)
    )
    error = abs(chroma_noise_gain(after, before) - 2)
    yield Row(hazard, "chroma noise of 4:2:0 video, twice as large", error, 0.1, "of 2")


def _refused(image: AnyImage, line: str) -> bool:
    """Whether the image is refused with a message that matches `line`."""
    try:
        enhance(image)
    except ImageError as refusal:
        return re.search(line, str(refusal)) is not None
    return False


def _error(pixels: AnyImage, params: EnhanceParams) -> float:
    """Largest difference to float64 in grey levels, with the same statistics."""
    result = enhance(pixels, params)
    exact, _ = enhance_reference(pixels, params, statistics=result.statistics)
    return 255 * _most(result.image / full_scale(result.image.dtype), exact)


def _most(one: AnyImage, other: AnyImage | float) -> float:
    return float(np.abs(one.astype(np.float64) - other).max())


PARTS: Final[dict[str, Callable[[NDArray[np.uint8]], Iterator[Row]]]] = {
    "precision": _precision,
    "bytes": _bytes,
    "statistics": _statistics,
    "ends": _ends,
    "exponents": _exponents,
    "constants": _constants,
    "hues": _hues,
    "sizes": _sizes,
    "filter": _filter,
    "saturation": _saturation,
    "black": _black,
    "types": _types,
    "fields": _fields,
    "noise gains": _noise_gains,
    "vessel": extremes,
}
"""Rows by what they are of; `image` is ordinary tissue, (H, W, 3)."""
