"""The preset `vessel` one numpy step after the other, as plain as it reads: the oracle of its kernels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance.brightness import level, value_histogram, z_from_level
from enhance.calm_blotches import colors_around
from enhance.field import Spans
from enhance.image import AnyImage, BoolImage, Float32Image, Picture, read_mask, read_picture
from enhance.morphology import step_of
from enhance.params import EnhanceParams
from enhance.pipeline import enhance
from enhance.pixel_block import CHUNK
from enhance.reference import color_noise, redness
from enhance.reflections import BRIGHT, COARSE, COLORLESS, RIM
from enhance.result import EnhanceResult
from enhance.rows import ROWS, held_width, read_row, sums_of
from enhance.saturation import Saturation, stretch
from enhance.shown import Pixels, Shown
from enhance.statistics import Statistics
from enhance.vessel import VESSEL, VesselParams

ABSORPTION = np.array([0.15, 1.0, 0.8], dtype=np.float32)
LUMA = np.array([0.299, 0.587, 0.114], dtype=np.float32)
FLOOR, MOST, DIM = np.float32(8 / 255), np.float32(0.5), (0.15, 0.4)
SOFT = (1, 2, 1)
"""Weights of neighbours, along rows and columns."""
GRID = 2
"""Pixels along a side of the blocks in which blood is looked for."""
Planes = Sequence[Float32Image]
"""R, G and B, or a single grey, each (H, W) in [0, 1]."""


def vessels_of(
    image: AnyImage,
    params: VesselParams = VESSEL,
    *,
    tissue_mask: AnyImage | None = None,
    statistics: Statistics | None = None,
    pixels: Pixels = "automatic",
) -> EnhanceResult:
    """As `enhance.vessel.enhance_vessels`."""
    given = read_picture(image)
    picture = given.filled
    field = Shown.of(image, None, pixels).within(statistics).field
    inside = np.ones(image.shape[:2], bool) if field is None else field.mask()
    keep = read_mask(tissue_mask, picture) & inside
    colors = picture.colors
    was_grey = colors.ndim == 3 and bool((np.ptp(colors, axis=2) == 0).all())
    if was_grey:
        colors = colors[..., 0]
    planes = _split(colors)
    smoothing = 0.0
    if len(planes) == 3:
        noise = _noise(picture, keep, inside) if statistics is None else statistics.color_noise
        smoothing = params.color_smoothing * min(max(((noise or 0.0) - 0.2) / 0.2, 0.0), 1.0)
    if smoothing > 0:
        shown = Shown.of(image, None, pixels).within(statistics)
        planes = _split(read_picture(without_blotches(shown.pixels, shown.spans, smoothing)).colors)
        params = replace(params, shading=(1 - smoothing) * params.shading)
    calm = _calm(planes)
    bright = _largest(calm)
    dark = level(value_histogram(bright[keep]).cumsum()) if statistics is None else statistics.level
    bright_end = _bright_level(bright[keep]) if statistics is None else statistics.bright_level
    times = _times(bright_end, params.most_exposure)
    paper = EnhanceParams(z=1 - (1 - z_from_level(dark)) * params.lift, p=0.0, d_factor=0.0)
    red = statistics.redness if statistics is not None else _redness(picture, keep)
    share = 0.0 if len(planes) == 1 else _share_of_blood(red, params.least_redness)
    toned = enhance(_merged(calm), paper, tissue_mask=keep, statistics=statistics, pixels=field or "all")
    tones = _split(toned.image) if times == 1 else _exposed(calm, times, toned.statistics.z)
    colored = _colored(tones, toned.statistics.saturation_mean, params)
    exposed = [plane * np.float32(times) for plane in planes]
    is_colored = len(planes) == 3 and red is not None
    spared = min(params.spare_grey, 1.0) * _share_of_blood(red, 0.2) if is_colored else 0.0
    grey, params = _grey_of(red, params.spare_grey), replace(params, spare_grey=spared)
    density = _density(exposed, bright * np.float32(times), params, keep, share, grey)
    taken = [share * np.exp(-one * density) + (1 - share) * np.exp(-density) for one in ABSORPTION]
    result = _merged([plane * left for plane, left in zip(colored, taken, strict=False)])
    result[~inside] = colors[~inside]
    if was_grey:
        result = np.repeat(result[..., None], 3, axis=2)
    whole = picture.with_colors(result)
    if given.alpha is not None:
        whole[~given.visible, :3] = given.pixels[~given.visible]
    return EnhanceResult(whole, toned.statistics, ())


def without_blotches(pixels: NDArray[Any], spans: Spans, share: float) -> NDArray[Any]:
    """Pixels as `Shown` has them, `share` of whose differences to luma are those around, as rows are read: a
    level more or less would be more than one in the result."""
    (height, width), full = pixels.shape[:2], 255 if pixels.dtype == np.uint8 else 1
    around, whole, out = colors_around(pixels, full), held_width(width), np.empty_like(pixels)
    known = spans, np.float32(full), around, np.float32(share)
    work = np.empty((2, 3, whole), np.float32), np.full(2, -1), np.empty((2, CHUNK), np.float32)
    rows = tuple(np.zeros((ROWS, 3, whole), kind) for kind in (pixels.dtype, sums_of(pixels).dtype))
    for y in range(height):
        read_row(pixels, y, *known, *work, *rows)
        out[y] = rows[0][y % ROWS, :, :width].T
    return out


def _density(
    planes: Planes,
    bright: Float32Image,
    params: VesselParams,
    keep: BoolImage,
    share: float,
    grey: tuple[float, float],
) -> Float32Image:
    """Times the strength, which is 0.65 where blood has none of its colour."""
    less = 0.0 if len(planes) == 1 else 1 - share
    shaded = replace(params, shading=share * params.shading)
    found = blood_density(planes, bright, shaded, keep, grey, 1 + less)
    return np.asarray(np.float32(params.strength * (1 - 0.35 * less)) * found)


def _noise(picture: Picture, keep: BoolImage, inside: BoolImage) -> float | None:
    is_whole = picture.dtype == np.uint8  # Their means are compared with whole numbers and halves.
    scaled = picture.pixels / 255 if is_whole else picture.colors.astype(np.float64)
    return color_noise(scaled, keep, inside)


def _redness(picture: Picture, keep: BoolImage) -> float | None:
    colors = picture.colors.astype(np.float64)
    return redness(colors, keep) if colors.ndim == 3 else None


def _share_of_blood(red: float | None, least: float) -> float:
    """0 up to half of what is least, 1 from there on, and in proportion between."""
    if red is None or red >= least:
        return 1.0
    return 0.0 if red <= least / 2 else (red - least / 2) / (least / 2)


def _grey_of(red: float | None, spare_grey: float) -> tuple[float, float]:
    """Logarithm of red over green up to which a place is grey, and from which on it is not: 0 and 0.15, or up
    to 0.12 and 0.2 in images whose redness is 0.26, by what exceeds 1."""
    beyond = max(spare_grey - 1, 0) * min(max(((red or 0.0) - 0.18) / 0.08, 0.0), 1.0)
    return 0.12 * beyond, 0.15 + 0.05 * beyond


def _bright_level(bright: Float32Image) -> float:
    """The level that nine tenths of the pixels do not exceed."""
    levels = np.sort(np.rint(255 * bright.astype(np.float64)))
    return float(levels[-(-9 * len(levels) // 10) - 1])


def _times(bright_end: float | None, most: float) -> float:
    """That take the bright end to 96 of 255 levels, by v -> t v / (1 + (t - 1) v); fewer near noise."""
    if bright_end is None or bright_end > 96 or bright_end < 4:
        return 1.0
    return min(96 / 159 * (255 / bright_end - 1), bright_end / 4, most)


def _exposed(calm: Planes, times: float, z: float) -> Planes:
    """Exposure and Eq 1 on V, in double precision; what is darker than 24 / `times` levels fades."""
    given = np.asarray(_largest(calm), np.float64)
    longer = times * given / (1 + (times - 1) * given)
    lit = (longer ** (0.75 * z + 0.25) + 0.4 * (1 - z) * (1 - longer) + longer ** (2 - z)) / 2
    t = np.clip(given * times * 255 / 24, 0, 1)
    lit = given + t * t * (3 - 2 * t) * (lit - given)
    gain = np.divide(lit, given, out=np.zeros_like(lit), where=given > 0)
    return [np.asarray(plane * gain, np.float32) for plane in calm]


def blood_density(
    planes: Planes,
    bright: Float32Image,
    params: VesselParams,
    keep: BoolImage,
    grey: tuple[float, float],
    noisier: float = 1.0,
) -> Float32Image:
    """Optical density of narrow dark structures in green, (H, W) in [0, 0.5], of grey ones
    1 - `spare_grey` of it; by `contrast`, of all.

    The top-hat (image less its morphological opening, of radius `radius`) of `shading` log R - log G: narrow
    structures remain, while slow shading falls out, and of steps between tissues little is left. Noise is the
    median at evenly spread places.

    Args:
        planes: R, G and B, or a single grey, (H, W) in [0, 1].
        bright: (H, W) calm V, which tells reflections, and darkness, where density fades.
        keep: (H, W), True = its median density is noise.
        grey: logarithm of red over green up to which it is grey, and from which on it is not.
        noisier: so many times more counts as noise.
    """
    logs = [np.log(_blocks(_smooth(plane, SOFT), GRID) + FLOOR) for plane in planes[:2]]
    absorbed = -logs[0] if len(planes) == 1 else np.float32(params.shading) * logs[0] - logs[1]
    found = np.maximum(absorbed - _opened(absorbed, bright, params.radius), 0)
    apart = max(3, math.isqrt(found.size // (1 << 12)))
    keep = keep[::GRID, ::GRID]
    noise = np.float32(noisier * params.coring) * np.median(found[::apart, ::apart][keep[::apart, ::apart]])
    square = found * found
    cored = found * square / (square + noise * noise + np.float32(1e-12))
    density = _fade(_blocks(bright, GRID)) * MOST * np.tanh(cored / MOST)
    if len(planes) > 1:
        red = absorbed + np.float32(1 - params.shading) * np.log(_blocks(bright, GRID) + FLOOR)
        density *= 1 - np.float32(params.spare_grey) * (1 - _rise(red, grey))
    seen, lit = (one[::apart, ::apart][keep[::apart, ::apart]] for one in (absorbed, _blocks(bright, GRID)))
    beyond = np.maximum(absorbed - _middle(seen, lit, 0.0 if len(planes) == 1 else params.shading), 0)
    density += np.float32(params.contrast) * beyond**2 / (beyond**2 + beyond + np.float32(0.1))
    return _brought_up(np.asarray(density, np.float32), GRID, bright.shape)


def _middle(absorbed: Float32Image, bright: Float32Image, shading: float) -> float:
    """Median, weighted by 0.05 without colour and by 1.05 with it."""
    color = (absorbed + np.float32(1 - shading) * np.log(bright + FLOOR)).astype(np.float64)
    order = np.argsort(absorbed)
    passed = np.cumsum((0.05 + np.clip((color - 0.05) / 0.1, 0, 1))[order])
    return float(absorbed[order][passed >= passed[-1] / 2][0])


def _opened(absorbed: Float32Image, bright: Float32Image, radius: int) -> Float32Image:
    """Opened by a disc, at a size that leaves it 8 to 15 blocks in radius, and smoothed."""
    step = step_of(radius)
    small = filled(_blocks(absorbed, step // GRID), _blocks(bright, GRID), radius // step)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * (radius // step) + 1,) * 2)
    opened = cv2.morphologyEx(small, cv2.MORPH_OPEN, disc, borderType=cv2.BORDER_REPLICATE)
    return _brought_up(cv2.GaussianBlur(opened, (3, 3), 0.6), step // GRID, absorbed.shape)


def _brought_up(blocks: Float32Image, side: int, shape: tuple[int, ...]) -> Float32Image:
    """From blocks to `shape`, which they cover."""
    size = blocks.shape[1] * side, blocks.shape[0] * side
    return np.asarray(cv2.resize(blocks, size), np.float32)[: shape[0], : shape[1]]


def filled(absorbed: Float32Image, value: Float32Image, radius: int) -> Float32Image:
    """As `enhance.reflections.without_reflections`."""
    height, width = absorbed.shape
    bright = np.asarray(cv2.resize(value, (width, height)), np.float32)
    seen = 1 - _rise(bright, BRIGHT) * (1 - _rise(absorbed, COLORLESS))
    seen = np.asarray(cv2.erode(seen, np.ones((2 * RIM + 1, 2 * RIM + 1), np.uint8)), np.float32)
    reach = radius // COARSE * 4 + 1
    sums, shares = (cv2.blur(_averages(plane, COARSE), (reach, reach)) for plane in (absorbed * seen, seen))
    around = _brought_up(sums / np.maximum(shares, np.float32(1e-3)), COARSE, absorbed.shape)
    return np.asarray(absorbed + (1 - seen) * np.maximum(around - absorbed, 0), np.float32)


def _rise(values: Float32Image, bounds: tuple[float, float]) -> Float32Image:
    low, high = bounds
    return np.asarray(np.clip((values - low) / (high - low), 0, 1), np.float32)


def _averages(plane: Float32Image, side: int) -> Float32Image:
    """Means over blocks, those at the edge of what there is of them."""
    padded, there = (
        np.pad(one, ((0, -one.shape[0] % side), (0, -one.shape[1] % side))) for one in (plane, plane * 0 + 1)
    )
    return np.asarray(_blocks(padded, side) / _blocks(there, side), np.float32)


def _blocks(plane: Float32Image, step: int) -> Float32Image:
    """Means; an odd edge repeats."""
    height, width = plane.shape
    whole = np.pad(plane, ((0, -height % step), (0, -width % step)), mode="edge")
    return np.asarray(whole.reshape(whole.shape[0] // step, step, -1, step).mean(axis=(1, 3)), np.float32)


def _smooth(plane: Float32Image, weights: tuple[float, ...]) -> Float32Image:
    kernel = np.array(weights) / sum(weights)
    return np.asarray(cv2.sepFilter2D(plane, cv2.CV_32F, kernel, kernel, borderType=cv2.BORDER_REFLECT_101))


def _calm(planes: Planes) -> Planes:
    """Differences of R, G and B to luma, smoothed; at no pixel is any channel brighter than V was."""
    if len(planes) == 1:
        return planes
    smooth = [_smooth(plane, SOFT) for plane in planes]
    fine = sum(share * (plane - blurred) for share, plane, blurred in zip(LUMA, planes, smooth, strict=True))
    most = _largest(planes)
    return [np.clip(blurred + fine, 0, most) for blurred in smooth]


def _colored(planes: Planes, saturation_mean: float, params: VesselParams) -> Planes:
    """`gamma` on V, and S by Eqs 11 and 12 within its bounds; the hue stays (see `saturation.recolor`)."""
    bright = _largest(planes)
    deepened = bright + _fade(bright) * (bright ** np.float32(params.gamma) - bright)
    if len(planes) == 1:
        return [deepened]
    floor = np.maximum(bright, np.float32(1e-6))
    white = np.asarray(-_largest([-plane for plane in planes]) / floor, dtype=np.float32)
    chroma = np.maximum(1 - white, np.float32(1e-6))
    stretched = stretch(Saturation(chroma=chroma, white=white), saturation_mean, params.d_factor)
    most = np.minimum(np.float32(params.most_color), 1 / chroma)
    slope = deepened / floor * np.clip(stretched / chroma, 1, most)
    return [deepened - slope * (bright - plane) for plane in planes]


def _largest(planes: Planes) -> Float32Image:
    largest = planes[0]
    for plane in planes[1:]:
        largest = np.maximum(largest, plane)
    return largest


def _split(colors: AnyImage) -> Planes:
    return [np.asarray(plane, dtype=np.float32) for plane in cv2.split(colors)]


def _merged(planes: Planes) -> Float32Image:
    merged = planes[0] if len(planes) == 1 else cv2.merge(list(planes))
    return np.asarray(merged, dtype=np.float32)


def _fade(bright: Float32Image) -> Float32Image:
    """Smoothstep between the two V of DIM."""
    low, high = DIM
    t = np.clip((bright - np.float32(low)) / np.float32(high - low), 0, 1)
    return np.asarray(t * t * (3 - 2 * t), dtype=np.float32)
