"""Enhances one image after another, or one image many times over, and computes only what has changed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance import brightness, needs, saturation
from enhance.chunk import BINS, BLOCK
from enhance.guided_filter import WindowModels, Windows, shrunk_radius
from enhance.image import AnyImage, Float32Image, ImageError, Picture, full_scale, read_mask, read_picture
from enhance.kernels import (
    FROM_LOGARITHM,
    FROM_POWER,
    KEEP_LOGARITHM,
    KEEP_POWER,
    NOTHING,
    render,
)
from enhance.params import DEFAULTS, EnhanceParams
from enhance.powers import LOG2_ZERO
from enhance.result import EnhanceResult
from enhance.statistics import LiveStatistics, Statistics, Tally
from enhance.survey import survey

LIKELY_SIGMA: Final = 64.0
"""Of Q on real images, in grey levels; all that is needed of it before it is measured is that P is 1/2."""

NO_VALUES: Final = np.empty((0, 0), np.float32)
NO_MODELS: Final = np.empty((0, 2, 1, 1), np.float32)
UNMEASURED: Final = Statistics(level=0.0, z=1.0, saturation_mean=0.0, sigmas=(), p=(), scope="image")
"""For a pass that only measures."""


@dataclass(frozen=True, eq=False)
class _Shown:
    """The image at hand, as the kernels read it."""

    picture: Picture
    pixels: NDArray[Any]
    """(H, W, 3), C-contiguous, uint8 or float32; grey three times."""
    keep: NDArray[np.uint8]
    """(H, W), 1 = counts in the statistics; empty: all count."""

    @property
    def full(self) -> int:
        return full_scale(self.pixels.dtype)


@dataclass(frozen=True, eq=False)
class _Survey:
    """What the first pass finds."""

    subsample: int
    low: Float32Image
    """Block means of V."""
    histogram: NDArray[np.int64]
    """(256,) of V over the kept pixels."""
    chroma: float
    """Sum of S over the kept pixels."""

    @property
    def count(self) -> int:
        return int(self.histogram.sum())

    def range(self, rounding: float) -> tuple[float, float]:
        """Darkest and brightest V counted, widened by what rounding hides, in grey levels."""
        levels = np.flatnonzero(self.histogram)
        return max(levels[0] - rounding, 0) / 255, min(levels[-1] + rounding, 255) / 255

    @property
    def mean(self) -> float:
        """Of V, in [0, 1]."""
        return float(self.histogram @ np.arange(BINS)) / (255 * max(self.count, 1))


@dataclass(frozen=True, eq=False)
class _Moments:
    """(n_scales,) of each scale's Q over the kept pixels, as in Tally."""

    windows: Windows
    means: NDArray[np.float64]
    squares: NDArray[np.float64]


@dataclass(frozen=True)
class _Made:
    """What V* is made from."""

    windows: Windows
    z: float
    p: tuple[float, ...]
    left_out: tuple[bool, ...]


class Enhancer:
    """Show it an image, then enhance that as often as the parameters change.

    A moved d-factor leaves V* as it is; a moved z or P does not filter again; a moved radius filters one
    scale. The memory for all that stays from image to image. Not to be used from two threads at once.
    """

    def __init__(self, live: LiveStatistics | None = None) -> None:
        """live: smooth the statistics from image to image; None: each image has its own."""
        self._live = live
        self._before: Statistics | None = None
        self._last: Statistics | None = None
        self._shown: _Shown | None = None
        self._survey: _Survey | None = None
        self._models = WindowModels()
        self._moments: _Moments | None = None
        self._reaches: tuple[Windows, tuple[float, ...]] | None = None
        self._made: _Made | None = None
        self._values_from: _Made | None = None
        self._values = NO_VALUES
        self._kept_from: _Made | None = None
        self._kept = np.empty((0, 0, 0), np.float32)

    def show(self, image: AnyImage, tissue_mask: AnyImage | None = None) -> None:
        """Take the next image; see `enhance.enhance` for both. It must not change while it is in use.

        Raises:
            ImageError: an image or mask that cannot be used; the image before it stays.
        """
        picture = read_picture(image)
        keep = np.empty((0, 0), np.uint8)
        if tissue_mask is not None or picture.alpha is not None:
            keep = np.ascontiguousarray(read_mask(tissue_mask, picture)).view(np.uint8)
        self._shown = _Shown(picture, _interleaved(picture), keep)
        self._survey = self._moments = self._reaches = None
        self._made = self._values_from = self._kept_from = None
        self._models.forget()
        self._before = self._last

    def enhance(
        self, params: EnhanceParams = DEFAULTS, *, statistics: Statistics | None = None
    ) -> EnhanceResult:
        """The image that is shown, enhanced; see `enhance.enhance`.

        Raises:
            ImageError: statistics that cannot be used, or no pixel to measure.
        """
        if statistics is not None:
            return self._draw(params, statistics.resolved(params), tight=True)
        if params.p is not None:
            self._last = self._statistics(params, ())
            return self._draw(params, self._last, tight=True)
        if self._is_measured(params):
            self._last = self._statistics(params, self.tally(params).sigmas)
            return self._draw(params, self._last)
        # P is 1/2 on nearly every image: draw with that, which measures Q on the way.
        likely = self._statistics(params, (LIKELY_SIGMA,) * len(params.radii))
        drawn = self._draw(params, likely, measure=True)
        self._last = used = self._statistics(params, self.tally(params).sigmas)
        return replace(drawn, statistics=used) if used.p == likely.p else self._draw(params, used)

    def tally(self, params: EnhanceParams) -> Tally:
        """Sums over the kept pixels of the image that is shown, to be pooled with those of others."""
        seen = self._surveyed(params.subsample)
        if self._moments is None or self._moments.windows != _windows(params):
            nothing = (True,) * len(params.radii)
            self._render(params, UNMEASURED, nothing, measure=True)
        assert self._moments is not None
        return Tally(seen.count, seen.histogram, seen.chroma, self._moments.means, self._moments.squares)

    @property
    def _now(self) -> _Shown:
        if self._shown is None:
            raise ImageError("expected an image to be shown before it is enhanced")
        return self._shown

    def _is_measured(self, params: EnhanceParams) -> bool:
        return self._moments is not None and self._moments.windows == _windows(params)

    def _surveyed(self, subsample: int) -> _Survey:
        """The first pass; only the low resolution depends on a parameter."""
        if self._survey is None or self._survey.subsample != subsample:
            now = self._now
            rows, columns = (-(-size // subsample) for size in now.pixels.shape[:2])
            low, blocks = np.empty((rows, columns), np.float32), -(-rows // BLOCK)
            histograms, chroma = np.empty((blocks, BINS), np.int64), np.empty(blocks)
            survey(now.pixels, now.keep, np.float32(now.full), subsample, low, histograms, chroma)
            self._survey = _Survey(subsample, low, histograms.sum(axis=0), float(chroma.sum()))
        return self._survey

    def _statistics(self, params: EnhanceParams, sigmas: tuple[float, ...]) -> Statistics:
        """Those of the shown image with these sigmas, smoothed if the stream is live."""
        seen = self._surveyed(params.subsample)
        squares = seen.count * (np.array(sigmas) / 255) ** 2
        tally = Tally(seen.count, seen.histogram, seen.chroma, np.zeros(len(sigmas)), squares)
        measured = tally.statistics(params, "image")
        if self._live is None:
            return measured
        return self._live.follow(self._before, measured).resolved(params)

    def _draw(
        self, params: EnhanceParams, used: Statistics, *, measure: bool = False, tight: bool = False
    ) -> EnhanceResult:
        """measure: Q as well; tight: spend time on a tight bound, as it pays where Q need not be measured."""
        picture = self._now.picture
        grey = picture.pixels.ndim == 2
        left_out, omitted = needs.decide(params, used, grey, self._reach(params, used, tight))
        out = self._render(params, used, left_out, measure)
        return EnhanceResult(_finished(picture, out), used, omitted)

    def _render(
        self, params: EnhanceParams, used: Statistics, left_out: tuple[bool, ...], measure: bool
    ) -> NDArray[Any]:
        """The second pass, or as much of it as is needed; the result is (H, W, 3)."""
        now, seen, windows = self._now, self._surveyed(params.subsample), _windows(params)
        made = _Made(windows, used.z, used.p, left_out)
        known = made == self._values_from and not measure
        if known or (all(left_out) and not measure):
            models, exponents = NO_MODELS, np.empty(0, np.float32)
        else:
            models = self._models.of(seen.low, windows)
            exponents = np.where(left_out, -1.0, used.p or 0.0).astype(np.float32)
        stage = NOTHING if measure or known else self._stage(made)
        values = self._values_for(made) if not measure else NO_VALUES
        rows = now.pixels.shape[0]
        sums = np.empty((rows if measure else 0, len(windows), 2))
        out = np.empty_like(now.pixels)
        render(
            now.pixels,
            now.keep,
            np.float32(now.full),
            params.subsample,
            models,
            exponents,
            _curve(used.z) if now.full > 1 else np.empty(0, np.float32),
            np.float32(used.z),
            np.float32(saturation.pull(used.saturation_mean, params.d_factor)),
            params.keep_black,
            np.float32(seen.mean),
            known,
            values,
            stage,
            self._kept,
            sums,
            out,
        )
        self._made = made
        if measure:
            self._moments = _moments(windows, sums.sum(axis=0), seen)
        return out

    def _values_for(self, made: _Made) -> Float32Image:
        """Where V* is or goes: it is kept from the second time on that it is made (a moved d-factor)."""
        if made == self._values_from:
            return self._values
        if made != self._made:
            return NO_VALUES
        shape = self._now.pixels.shape[:2]
        if self._values.shape != shape:
            self._values = np.empty(shape, np.float32)
        self._values_from = made
        return self._values

    def _stage(self, made: _Made) -> int:
        """What to take from the last pass: E if only z has moved since, a logarithm if P has.

        The first such move keeps it for those that follow.
        """
        steady, moving = replace(made, z=0.0), replace(made, z=0.0, p=())
        if self._kept_from == steady:
            return FROM_POWER
        if self._kept_from == moving and 0.5 not in made.p:
            return FROM_LOGARITHM
        if self._made is None or self._made.windows != made.windows or all(made.left_out):
            return NOTHING
        if self._made.p != made.p and 0.5 in made.p:
            return NOTHING
        shape = (len(made.windows), *self._now.pixels.shape[:2])
        if self._kept.shape != shape:
            self._kept = np.empty(shape, np.float32)
        self._kept_from = steady if self._made.p == made.p else moving
        return KEEP_POWER if self._made.p == made.p else KEEP_LOGARITHM

    def _reach(self, params: EnhanceParams, used: Statistics, tight: bool) -> tuple[float, ...]:
        """Bounds on each scale's effect, as loose as the decision allows: tighter ones take longer."""
        seen, now, windows = self._surveyed(params.subsample), self._now, _windows(params)
        if tight and self._reaches is not None and self._reaches[0] == windows:
            return self._reaches[1]
        rounding = 0.0 if now.full > 1 else 0.5
        reach = needs.range_reach(*(seen.range(rounding) if now.keep.size == 0 else (0.0, 1.0)))
        loose = (reach,) * len(windows)
        if not tight or params.omit_below == 0 or all(needs.left_out(used.p, loose, params.omit_below)):
            return loose
        models = self._models.of(seen.low, windows)
        sampled = needs.sampled_reaches(seen.low, models)
        likely = needs.left_out(used.p, sampled, params.omit_below)
        if not any(out and p > 0 for out, p in zip(likely, used.p, strict=True)):
            return loose
        reaches = needs.local_reaches(now.pixels, now.full, params.subsample, models)
        self._reaches = windows, reaches
        return reaches


def _windows(params: EnhanceParams) -> Windows:
    return tuple(
        (shrunk_radius(radius, params.subsample), params.eps, params.subsample) for radius in params.radii
    )


def _moments(windows: Windows, sums: NDArray[np.float64], seen: _Survey) -> _Moments:
    count = max(seen.count, 1)
    drift = sums[:, 0] / count
    squares = np.maximum(sums[:, 1] - count * drift**2, 0)
    return _Moments(windows, np.float32(seen.mean) + drift, squares)


def _curve(z: float) -> Float32Image:
    """(256,) log2 of Vn (Eq 1) of each grey level."""
    lifted = brightness.brighten(np.arange(BINS) / 255, z)
    logs = np.log2(lifted, where=lifted > 0, out=np.full(BINS, float(LOG2_ZERO)))
    return logs.astype(np.float32)


def _interleaved(picture: Picture) -> NDArray[Any]:
    """(H, W, 3) uint8 or float32 in [0, 1]."""
    pixels = picture.pixels if picture.dtype == np.uint8 else picture.colors
    pixels = np.ascontiguousarray(pixels)
    return pixels if pixels.ndim == 3 else np.asarray(cv2.cvtColor(pixels, cv2.COLOR_GRAY2RGB))


def _finished(picture: Picture, out: NDArray[Any]) -> AnyImage:
    """The input's shape and type again, alpha untouched."""
    colors = out if picture.pixels.ndim == 3 else np.ascontiguousarray(out[..., 0])
    if picture.dtype not in (np.uint8, np.float32):
        return picture.with_colors(colors)
    return colors if picture.alpha is None else np.dstack((colors, picture.alpha))
