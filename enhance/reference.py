"""The literal reading of Eqs 1-12: float64, every printed equation on a line of its own, slow. The oracle,
as `ridge` is of `enhance.ridges.vesselness`.

It shares the parameters, the statistics' form and the field of view with the pipeline, and no arithmetic. The
decisions that the paper leaves open are the same: the floor e in Eq 7, windows clipped at the border,
k = d_factor.
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance.image import AnyImage, BoolImage, read_picture
from enhance.params import DEFAULTS, EnhanceParams
from enhance.ridges import SHADOW, gaussian_kernel
from enhance.saturation import color_share
from enhance.shown import Pixels, Shown
from enhance.statistics import Statistics

Float64Image = NDArray[np.float64]


def enhance_reference(
    image: AnyImage,
    params: EnhanceParams = DEFAULTS,
    *,
    tissue_mask: BoolImage | None = None,
    statistics: Statistics | None = None,
    pixels: Pixels = "automatic",
) -> tuple[Float64Image, Statistics]:
    """What `enhance` computes, in float64 and not rounded: the image in [0, 1] and the statistics used.

    The image must be one that `enhance` accepts; it is not checked.
    """
    full = np.iinfo(image.dtype).max if image.dtype.kind == "u" else 1
    given = image.astype(np.float64) / full
    scaled = given.copy()
    if image.ndim == 3:
        scaled[..., :3] = read_picture(image).filled.pixels.astype(np.float64) / full
    if image.ndim == 2:
        value, visible = scaled, np.ones(image.shape, dtype=bool)
        hue, chroma = np.zeros_like(value), np.zeros_like(value)
    else:
        hue, chroma, value = hsv_from_rgb(scaled[..., :3])
        visible = scaled[..., 3] > 0 if image.shape[2] == 4 else np.ones(value.shape, dtype=bool)
    field = Shown.of(image, None, pixels).within(statistics).field
    inside = np.ones(value.shape, dtype=bool) if field is None else field.mask()
    keep = inside & visible if tissue_mask is None else inside & visible & tissue_mask
    filtered = [guided(value, radius, params) for radius in params.radii]
    used = statistics
    if used is None:
        snr = chroma_snr(scaled, keep, inside) if image.ndim == 3 and params.d_factor is None else None
        used = replace(_measured(value, chroma, filtered, keep, params, snr), field=field)
        if image.ndim == 3:
            used = replace(used, redness=redness(scaled, keep), color_noise=color_noise(scaled, keep, inside))
    enhanced = _new_value(value, filtered, used)
    if image.ndim == 3:
        whole = stretched(chroma, used.saturation_mean, params.k)
        new_chroma = chroma + used.color * (whole - chroma)
        enhanced = rgb_from_hsv(hue, new_chroma, enhanced)
    if params.keep_black:
        enhanced = _faded(scaled[..., :3] if image.ndim == 3 else scaled, enhanced, value)
    untouched = ~(inside & visible)
    enhanced[untouched] = (given[..., :3] if image.ndim == 3 else given)[untouched]
    return enhanced if image.ndim == 2 else np.concatenate((enhanced, scaled[..., 3:]), axis=2), used


def _measured(
    value: Float64Image,
    chroma: Float64Image,
    filtered: list[Float64Image],
    keep: BoolImage,
    params: EnhanceParams,
    snr: float | None,
) -> Statistics:
    levels = np.sort(np.rint(255 * value[keep]))
    level = levels[-(-len(levels) // 10) - 1]  # the first at which a tenth of all is reached
    bright = levels[-(-9 * len(levels) // 10) - 1]
    z = 0.0 if level <= 50 else (level - 50) / 100 if level < 150 else 1.0  # Eq 2
    sigmas = tuple(float(np.std(255 * q[keep])) for q in filtered)
    p = tuple(_exponent(sigma, params) for sigma in sigmas)
    mean = float(np.mean(chroma[keep]))
    strength = params.strength
    whole = p if params.p is None else params.p if isinstance(params.p, tuple) else (params.p,) * len(p)
    color = color_share(mean, snr) if params.d_factor is None else 1.0
    return Statistics(
        level=float(level),
        z=max(0.0, 1 - strength * (1 - (float(z) if params.z is None else params.z))),
        saturation_mean=mean,
        sigmas=sigmas,
        p=tuple(strength * one for one in whole),
        scope="image",
        chroma_snr=snr,
        color=min(1.0, strength * color),
        bright_level=float(bright),
    )


def chroma_snr(scaled: Float64Image, keep: BoolImage, inside: BoolImage) -> float | None:
    """As `enhance.chroma.chroma_snr`, place by place."""
    step = max(6, int(np.sqrt(keep.size / 1024)))
    chroma, noise = [], []
    for y in range(0, keep.shape[0] - 5, step):
        for x in range(0, keep.shape[1] - 5, step):
            if not (keep[y + 3, x + 3] and inside[y : y + 6 : 5, x : x + 6 : 5].all()):
                continue
            colors = 255 * scaled[y : y + 6, x : x + 6, :3]
            halved = colors.reshape(3, 2, 3, 2, 3).mean(axis=(1, 3))
            response = np.einsum("i,j,ijc->c", (1, -2, 1), (1, -2, 1), halved)
            chroma.append(np.ptp(colors[3, 3]))
            noise.append(np.abs(response[[0, 2]] - response[1]))
    if not chroma:
        return None
    deviation = np.median(noise, axis=0).max() / (6 * 0.6745)
    return float(np.mean(chroma) / max(deviation, 1.0))


def redness(scaled: Float64Image, keep: BoolImage) -> float | None:
    """As `enhance.redness`: what red exceeds green by, over V, of some pixels, no clipped ones; None of
    grey images."""
    step = max(1, int(np.sqrt(keep.size // 1024)))
    colors = scaled[::step, ::step, :3][keep[::step, ::step]]
    colors = colors[np.min(colors[:, :2], axis=1, initial=1) < 250 / 255]
    light = np.max(colors, axis=1, initial=0).sum()
    if light == 0 or not np.ptp(scaled[..., :3], axis=2).any():
        return None
    return float((colors[:, 0] - colors[:, 1]).sum() / light)


def color_noise(scaled: Float64Image, keep: BoolImage, inside: BoolImage) -> float | None:
    """As `enhance.color_noise`: of second differences of red and green, the share of opposite ones."""
    if not np.ptp(scaled[..., :3], axis=2).any():
        return None
    step, found = max(12, int(np.sqrt(keep.size // 512))), []
    for y in range(0, keep.shape[0] - 11, step):
        for x in range(0, keep.shape[1] - 11, step):
            if not (keep[y + 6, x + 6] and inside[[y, y + 11], x : x + 12].all()):
                continue
            # Rounded, as it is a question of more or less than numbers that means of whole numbers can be.
            means = scaled[y : y + 12, x : x + 12, :2].reshape(3, 4, 3, 4, 2).mean(axis=(1, 3))
            means = np.round(255 * means, 9)
            for row in (means[1], means[:, 1]):
                if row[1].max() >= 24 and row.max() < 250:
                    red, green = row[0] - 2 * row[1] + row[2]
                    smaller, larger = sorted((abs(red), abs(green)))
                    found.append(red * green < 0 and smaller > 1.5 and larger < 96)
    return sum(found) / max(len(found), 128) if found else None


def _exponent(sigma: float, params: EnhanceParams) -> float:
    first, last = (2.0, 10.0) if params.p_form == "literal" else (2.125, 10.25)
    if sigma <= first:  # Eq 9
        return 7 / 4
    if sigma < last:
        return (27 - 2 * sigma) / 13
    return 1 / 2


def _new_value(value: Float64Image, filtered: list[Float64Image], used: Statistics) -> Float64Image:
    z = used.z
    brightened = (value ** (0.75 * z + 0.25) + 0.4 * (1 - value) * (1 - z) + value ** (2 - z)) / 2  # Eq 1
    total = np.zeros_like(value)
    for q, p in zip(filtered, used.p, strict=True):
        ratio = ((q + 1 / 255) / (value + 1 / 255)) ** p  # Eq 7
        total += brightened**ratio  # Eq 8
    return total / len(filtered)  # Eq 10


def _faded(scaled: Float64Image, enhanced: Float64Image, value: Float64Image) -> Float64Image:
    t = np.clip(value * 255 / 24, 0, 1)
    weight = 3 * t**2 - 2 * t**3
    if scaled.ndim == 3:
        weight = weight[..., None]
    return scaled + weight * (enhanced - scaled)


def guided(value: Float64Image, radius: int, params: EnhanceParams) -> Float64Image:
    """Q of Eqs 3-6 with guide and input both `value`: subsampled, solved, and brought up again.

    E[V^2] of a window is the mean over blocks of the mean of V^2, so that subsampling takes nothing from its
    variance; (2 r + 1) / s pixels wide. Windows of 8 pixels or more at 2 s are computed there.
    """
    s, rows, columns = params.subsample, *value.shape
    mean, square = block_means(value, s), block_means(value**2, s)
    if s > 1 and (2 * radius + 1) / (2 * s) >= 8:
        s, mean, square = 2 * s, block_means(mean, 2), block_means(square, 2)
    reach = max(((2 * radius + 1) / s - 1) / 2, 0.0)
    mu = mean_bar = window_mean(mean, reach)
    square_bar = window_mean(square, reach)
    sigma2 = square_bar - mu**2
    a = (square_bar - mu * mean_bar) / (sigma2 + params.eps)  # Eq 4
    b = mean_bar - a * mu  # Eq 5
    a_bar = bilinear(window_mean(a, reach), s)[:rows, :columns]
    b_bar = bilinear(window_mean(b, reach), s)[:rows, :columns]
    return a_bar * value + b_bar  # Eq 6


def block_means(image: Float64Image, size: int) -> Float64Image:
    """Means of size x size blocks; the last row and column are repeated where the image ends within one."""
    padded = np.pad(image, [(0, -length % size) for length in image.shape], mode="edge")
    return np.asarray(sum(padded[i::size, j::size] for i in range(size) for j in range(size)) / size**2)


def window_mean(image: Float64Image, reach: float) -> Float64Image:
    """Mean of the part of each window inside the image; it is 2 reach + 1 wide, its outer pixels in part."""
    down, across = (
        np.clip(reach + 1 - np.abs(np.subtract.outer(at, at)), 0, 1) for at in map(np.arange, image.shape)
    )
    return np.asarray(down @ image @ across / np.outer(down.sum(axis=1), across.sum(axis=1)))


def bilinear(low: Float64Image, factor: int) -> Float64Image:
    """`low` enlarged by a whole factor, pixel centres aligned, borders repeated."""
    for axis in (0, 1):
        size = low.shape[axis]
        at = np.clip((np.arange(size * factor) + 0.5) / factor - 0.5, 0, size - 1)
        first = np.minimum(at.astype(int), max(size - 2, 0))
        second = np.minimum(first + 1, size - 1)
        weight = np.expand_dims(at - first, 1 - axis)
        low = (1 - weight) * low.take(first, axis) + weight * low.take(second, axis)
    return low


def stretched(chroma: Float64Image, mean: float, d_factor: float) -> Float64Image:
    """S* of Eqs 11 and 12 as printed; S = 0 stays 0, S_m = 1 keeps only full saturation, k = 0 is off."""
    if d_factor == 0:
        return chroma
    out = np.where(chroma == 1, 1.0, 0.0)
    d_below = 2 * mean**3 - 3 * mean**2 + 1
    if d_below == 0:
        return out
    d = (3 * mean**2 - 2 * mean**3) / d_below  # Eq 12
    some = chroma > 0
    out[some] = 1 / (1 + d_factor * d * (1 / chroma[some] - 1) ** 2)  # Eq 11
    return out


def hsv_from_rgb(rgb: Float64Image) -> tuple[Float64Image, Float64Image, Float64Image]:
    """H in [0, 6), S and V in [0, 1], each (H, W); H = 0 for grey and S = 0 for black."""
    red, green, blue = np.moveaxis(rgb, 2, 0)
    value, low = rgb.max(axis=2), rgb.min(axis=2)
    spread = np.where(value > low, value - low, 1.0)
    sector = np.where(
        value == red,
        (green - blue) / spread % 6,
        np.where(value == green, (blue - red) / spread + 2, (red - green) / spread + 4),
    )
    hue = np.where(value > low, sector, 0.0)
    chroma = np.where(value > 0, (value - low) / np.where(value > 0, value, 1.0), 0.0)
    return hue, chroma, value


def rgb_from_hsv(hue: Float64Image, chroma: Float64Image, value: Float64Image) -> Float64Image:
    """(H, W, 3) in [0, 1], by Smith's trapezoids (1978): a channel is V (1 - S clip(...))."""
    channels = []
    for offset in (5, 3, 1):
        k = (offset + hue) % 6
        channels.append(value * (1 - chroma * np.clip(np.minimum(k, 4 - k), 0, 1)))
    return np.stack(channels, axis=2)


def ridge(green: Float64Image, sigma: float) -> Float64Image:
    """One scale of `vesselness`, (H, W)."""
    smooth = _derivative(green, sigma, 0, 0)
    xx, xy, yy = (_derivative(green, sigma, *order) for order in ((2, 0), (1, 1), (0, 2)))
    middle, apart = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    slope = np.hypot(_derivative(green, sigma, 1, 0), _derivative(green, sigma, 0, 1))
    line = sigma**2 * (middle + apart - np.abs(middle - apart)) - sigma * slope
    level = smooth + SHADOW * smooth.mean()
    relative = np.divide(line, level, out=np.zeros_like(line), where=level > 0)
    return np.asarray(np.maximum(relative, 0.0))


def _derivative(image: Float64Image, sigma: float, along_x: int, along_y: int) -> Float64Image:
    kernels = (gaussian_kernel(sigma, along_x), gaussian_kernel(sigma, along_y))
    return np.asarray(cv2.sepFilter2D(image, cv2.CV_64F, *kernels, borderType=cv2.BORDER_REFLECT))
