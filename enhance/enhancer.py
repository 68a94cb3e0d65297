"""Enhances one image after another, or one image many times over, and computes only what has changed."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from enhance import brightness, needs, saturation
from enhance.changed import changed
from enhance.chroma import places
from enhance.field import FieldOfView
from enhance.first_pass import first_pass
from enhance.guided_filter import Grids, Window, WindowModels, Windows, are_coarse, windows_of
from enhance.image import AnyImage, Float32Image, ImageError
from enhance.params import DEFAULTS, EnhanceParams
from enhance.pixel_block import BINS, BLOCK
from enhance.powers import LOG2_ZERO
from enhance.result import EnhanceResult
from enhance.result_memory import ResultMemory
from enhance.second_pass import (
    FROM_LOGARITHM,
    FROM_POWER,
    KEEP_LOGARITHM,
    KEEP_POWER,
    NOTHING,
    render,
)
from enhance.shown import Pixels, Shown
from enhance.statistics import LiveStatistics, Statistics, Tally, from_sums, require_classes
from enhance.stream import Stream
from enhance.survey import LIKELY_SIGMA, Moments, Survey

NO_VALUES: Final = np.empty((0, 0), np.float32)
NO_CURVE: Final = np.empty(0, np.float32)


class _Scale(NamedTuple):
    """What a scale's E is made from."""

    window: Window
    p: float | None
    """Rounded as in the kernels. None: of the logarithm of its ratio, which is the same for every P."""


class _Made(NamedTuple):
    """What V* is made from."""

    z: float
    scales: tuple[_Scale | None, ...]
    """None: left out."""


@lru_cache(maxsize=4)
def curve_of(z: float) -> Float32Image:
    """(256,) log2 of Vn (Eq 1) of each grey level."""
    lifted = brightness.brighten(np.arange(BINS) / 255, z)
    logs = np.log2(lifted, where=lifted > 0, out=np.full(BINS, float(LOG2_ZERO)))
    return logs.astype(np.float32)


class Enhancer:
    """Show it an image, then enhance it as often as the parameters change.

    A new d-factor leaves V* unchanged; a new z or P does not filter again; a new radius filters and
    measures one scale. Working memory is reused from image to image. Not
    thread-safe.

    Example:
        >>> import numpy as np
        >>> from enhance import EnhanceParams, Enhancer
        >>> enhancer = Enhancer()
        >>> enhancer.show(np.random.default_rng(0).integers(0, 200, (48, 64, 3), dtype=np.uint8))
        >>> settings = [EnhanceParams(d_factor=k) for k in (0.0, 0.5, 1.0)]
        >>> [enhancer.enhance(params).image.shape for params in settings]
        [(48, 64, 3), (48, 64, 3), (48, 64, 3)]
    """

    def __init__(self, live: LiveStatistics | None = None) -> None:
        """live: smooth the statistics from image to image; None: each image has its own."""
        self._stream = Stream(live)
        self._shown: Shown | None = None
        self._survey: Survey | None = None
        self._models = WindowModels()
        self._low = Grids(np.empty((0, 0, 0), np.float32), np.empty((0, 0, 0), np.float32))
        self._moments: dict[Window, Moments] = {}
        self._reaches: dict[Window, float] = {}
        self._made: _Made | None = None
        self._values_of: _Made | None = None
        self._values = NO_VALUES
        self._kept_of: list[_Scale | None] = []
        self._kept = np.empty((0, 0, 0), np.float32)
        self._results = ResultMemory()

    def show(
        self, image: AnyImage, tissue_mask: AnyImage | None = None, *, pixels: Pixels = "automatic"
    ) -> None:
        """Take the next image; see `enhance.enhance` for all three. It must not change while it is in use.

        Raises:
            ImageError: an image, mask or field that cannot be used; the previous image is kept.
        """
        self._take(self._stream.next(Shown.of(image, tissue_mask, pixels), pixels))

    def forget(self) -> None:
        """Let the image go, and what was made of it; the working memory stays for the next one."""
        self._take(None)

    @property
    def memory(self) -> int:
        """Bytes of working memory, and of the last result's."""
        arrays = *self._low, *self._models.memory, self._values, self._kept
        return self._results.size + sum([array.nbytes for array in arrays])

    def _take(self, shown: Shown | None) -> None:
        self._shown = shown
        self._survey = self._made = self._values_of = None
        self._moments, self._reaches, self._kept_of = {}, {}, []
        self._models.forget()

    def _look_within(self, statistics: Statistics | None) -> None:
        """See the shown image within its field of view, or that of the statistics."""
        shown = self._now.within(statistics)
        if shown is not self._shown:
            self._take(shown)

    def enhance(
        self, params: EnhanceParams = DEFAULTS, *, statistics: Statistics | None = None
    ) -> EnhanceResult:
        """The image that is shown, enhanced; see `enhance.enhance`.

        Raises:
            ImageError: statistics that cannot be used, or no pixel to measure.
            TypeError: `params` or `statistics` of another class.
        """
        require_classes(params, EnhanceParams, statistics)
        self._look_within(statistics)
        windows = self._windows(params)
        if statistics is not None:
            return self._draw(params, windows, statistics.resolved(params), tight=True)
        if params.p is not None:
            return self._draw(params, windows, self._used(self._measured(params, ()), params), tight=True)
        # P is 1/2 on nearly every image: draw with that, which measures on the way what is not known of Q.
        unknown = [one not in self._moments for one in windows]
        measured = self._measured(params, windows)
        likely = self._used(measured, params)
        drawn = self._draw(params, windows, likely, unknown)
        if not any(unknown):
            return drawn
        used = self._used(changed(measured, sigmas=self._sigmas(windows)), params)
        if used.p != likely.p:
            return self._draw(params, windows, used)
        return EnhanceResult(drawn.image, used, drawn.omitted)

    def tally(self, params: EnhanceParams) -> Tally:
        """Sums over the kept pixels of the image that is shown, to be pooled with those of others."""
        self._look_within(None)
        windows = self._windows(params)
        unknown = [one not in self._moments for one in windows]
        if any(unknown):
            self._render(params, windows, _Made(1.0, (None,) * len(windows)), (0.0, 1.0), unknown)
        seen = self._surveyed(params.subsample)
        moments = np.array([self._moments[one] for one in windows]).reshape(-1, 2)
        snr = seen.chroma_snr if params.d_factor is None else None
        colored = (0, 0.0) if snr is None else (seen.count, snr)
        sums = seen.count, seen.histogram, seen.chroma, moments[:, 0], moments[:, 1]
        return Tally(*sums, *colored, self._now.reds, self._now.opposites)

    @property
    def field(self) -> FieldOfView | None:
        """Of the image that is shown, as last enhanced or measured; None: all pixels count."""
        return self._now.field

    @property
    def _now(self) -> Shown:
        if self._shown is None:
            raise ImageError("expected an image to be shown before it is enhanced")
        return self._shown

    def _windows(self, params: EnhanceParams) -> Windows:
        return windows_of(params.radii, params.eps, params.subsample)

    def _surveyed(self, subsample: int) -> Survey:
        """The first pass; only the low resolution depends on a parameter."""
        if self._survey is None or self._survey.subsample != subsample:
            now = self._now
            rows, columns = (-(-size // subsample) for size in now.pixels.shape[:2])
            half = ((rows + 1) // 2, (columns + 1) // 2) if subsample > 1 else (0, 0)
            low, shapes = self._low, [(2, rows, columns), (2, *half)]
            if [grid.shape for grid in low] != shapes:
                low = self._low = Grids(*(np.empty(shape, np.float32) for shape in shapes))
            blocks = -(-rows // BLOCK)
            histograms, total = np.empty((blocks, BINS), np.int64), np.empty(BINS, np.int64)
            chroma = np.empty(blocks)
            step, *spread = places(*now.pixels.shape[:2])
            samples = np.empty((3, *spread) if not now.is_grey else (3, 0, 0))
            full = np.float32(now.full)
            first_pass(
                now.pixels,
                now.keep,
                now.spans,
                full,
                subsample,
                *low,
                histograms,
                chroma,
                step,
                samples,
                total,
            )
            self._survey = Survey(subsample, low, total, float(chroma.sum()), samples, now.full)
        return self._survey

    def _measured(self, params: EnhanceParams, windows: Windows) -> Statistics:
        """Those of the shown image."""
        seen, now = self._surveyed(params.subsample), self._now
        snr = seen.chroma_snr if params.d_factor is None else None
        sigmas = self._sigmas(windows)
        return from_sums(
            "image", seen.cumulative, seen.chroma, sigmas, snr, now.reds, now.opposites, now.field
        )

    def _sigmas(self, windows: Windows) -> tuple[float, ...]:
        """Of Q; likely ones where it is not measured."""
        known, seen = self._moments, self._survey
        if seen is None or not known:
            return (LIKELY_SIGMA,) * len(windows)
        return tuple([known[one].sigma(seen.count) if one in known else LIKELY_SIGMA for one in windows])

    def _used(self, measured: Statistics, params: EnhanceParams) -> Statistics:
        """Smoothed if the stream is live."""
        return self._stream.smoothed(measured, self._surveyed(params.subsample).histogram).resolved(params)

    def _draw(
        self,
        params: EnhanceParams,
        windows: Windows,
        used: Statistics,
        measured: Sequence[bool] = (),
        *,
        tight: bool = False,
    ) -> EnhanceResult:
        """measured: the scales of which Q is; tight: look closer at what may be left out, as it pays where Q
        need not be measured."""
        now = self._now
        reach = self._reach(params, windows, used, tight)
        left_out, omitted = needs.decide(params, used, now.is_grey, reach)
        scales = zip(windows, np.array(used.p, np.float32).tolist(), left_out, strict=True)
        made = _Made(used.z, tuple(None if out else _Scale(one, p) for one, p, out in scales))
        color = used.saturation_mean, used.color
        out = self._render(params, windows, made, color, measured or (False,) * len(windows))
        return EnhanceResult(now.finished(out), used, omitted)

    def _render(
        self,
        params: EnhanceParams,
        windows: Windows,
        made: _Made,
        color: tuple[float, float],
        measured: Sequence[bool],
    ) -> NDArray[Any]:
        """The second pass, or as much of it as is needed; the result is (H, W, 3).

        color: mean of S, and the share of its change in use.
        """
        now, seen = self._now, self._surveyed(params.subsample)
        known = made == self._values_of and not any(measured)
        values = NO_VALUES if any(measured) else self._values_for(made)
        stages = [NOTHING] * len(windows) if len(values) > 0 else self._stages(made, measured)
        wanted = [
            one is not None and stage not in (FROM_LOGARITHM, FROM_POWER) and not known
            for one, stage in zip(made.scales, stages, strict=True)
        ]
        filtered = [want or measure for want, measure in zip(wanted, measured, strict=True)]
        sums = np.empty((-(-now.pixels.shape[0] // (BLOCK * params.subsample)), len(windows), 2))
        totals: NDArray[np.float64] = np.empty((len(windows), 2))
        out = self._results.like(now.pixels)
        # Before the models: what Python has just used is in no cache any more once a kernel has run.
        powers = [-1.0 if one is None or one.p is None else one.p for one in made.scales]
        exponents, are_filtered, are_measured = (
            np.array(powers, np.float32),
            np.array(filtered),
            np.array(measured),
        )
        curve = curve_of(made.z) if now.full > 1 else NO_CURVE
        pull, mean = saturation.pull(color[0], params.k), seen.mean
        models = self._models.of(seen.low, windows, filtered)
        render(
            now.pixels,
            now.keep,
            now.spans,
            np.float32(now.full),
            params.subsample,
            *models,
            are_coarse(windows),
            are_filtered,
            are_measured,
            exponents,
            curve,
            np.float32(made.z),
            np.float32(pull),
            np.float32(color[1]),
            params.keep_black,
            np.float32(mean),
            known,
            values,
            np.array(stages),
            self._kept,
            sums,
            out,
            totals,
        )
        self._made = made
        for one, is_new, total in zip(windows, measured, totals.tolist(), strict=True):
            if is_new:
                self._moments[one] = Moments.of(total, seen)
        return out

    def _values_for(self, made: _Made) -> Float32Image:
        """Where V* is or goes: it is kept from the second time on that it is made (a moved d-factor)."""
        if made == self._values_of:
            return self._values
        if made != self._made:
            return NO_VALUES
        shape = self._now.pixels.shape[:2]
        if self._values.shape != shape:
            self._values = np.empty(shape, np.float32)
        self._values_of = made
        return self._values

    def _stages(self, made: _Made, measured: Sequence[bool]) -> list[int]:
        """What to take of each scale from an earlier pass, or to keep for later ones."""
        count = len(made.scales)
        if len(self._kept_of) != count:
            self._kept_of = [None] * count
        before = self._made.scales if self._made is not None else ()
        if len(before) != count:
            before = (None,) * count
        stages = [
            NOTHING if one is None or measured[index] else self._stage(index, one, before[index])
            for index, one in enumerate(made.scales)
        ]
        shape = (count, *self._now.pixels.shape[:2])
        if self._kept.shape != shape and any(stage != NOTHING for stage in stages):
            self._kept = np.empty(shape, np.float32)
        return stages

    def _stage(self, index: int, now: _Scale, before: _Scale | None) -> int:
        """E if the scale stays as it was, a logarithm if only its P moves: the first time, it is kept."""
        ratio = now._replace(p=None)
        if self._kept_of[index] == now:
            return FROM_POWER
        if self._kept_of[index] == ratio and now.p != 0.5:
            return FROM_LOGARITHM
        if before == now:
            self._kept_of[index] = now
            return KEEP_POWER
        if before is not None and before.window == now.window and now.p != 0.5:
            self._kept_of[index] = ratio
            return KEEP_LOGARITHM
        return NOTHING

    def _reach(
        self, params: EnhanceParams, windows: Windows, used: Statistics, tight: bool
    ) -> tuple[float, ...]:
        """Bounds on each scale's effect, no tighter than helps to leave it out."""
        seen, now = self._surveyed(params.subsample), self._now
        rounding = 0.0 if now.full > 1 else 0.5
        loose = needs.range_reach(*(seen.range(rounding) if now.counts_all else (0.0, 1.0)))
        reaches = [loose] * len(windows)
        if not tight:
            return tuple(reaches)

        def matters(index: int, reach: float) -> bool:
            return needs.scale_bound(used.p[index], reach, len(windows)) >= params.omit_below > 0

        unsure = [matters(index, loose) for index in range(len(windows))]
        models = self._models.of(seen.low, windows, unsure)
        for index in np.flatnonzero(unsure).tolist():
            one = windows[index]
            if one not in self._reaches:
                given = seen.low.fine, one, models[one.coarse][index]
                if not matters(index, needs.sparse_reach(*given)):
                    self._reaches[one] = needs.local_reach(*given)
            reaches[index] = self._reaches.get(one, loose)
        return tuple(reaches)
