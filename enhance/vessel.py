"""The preset `vessel`: the paper's brightness, gentle colour, and more of what looks like blood.

An own method beside the paper's, which stays the default. Its claim is visibility only: it darkens and
reddens narrow dark structures as more blood would, whether or not they are vessels. Local detail (Eqs 7-10)
stays as it is: strengthened, it shows noise by more than vessels.
"""

from __future__ import annotations

from dataclasses import dataclass as plain_dataclass
from dataclasses import replace
from typing import Annotated, Final, NamedTuple

import numpy as np
from annotated_types import Interval, Unit
from numpy.typing import NDArray
from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from enhance import vessel_curves
from enhance.brightness import z_from_level
from enhance.calm_blotches import NO_COLORS, colors_around
from enhance.color_noise import coarse_share
from enhance.exposure import exposure
from enhance.field import Spans
from enhance.image import AnyImage, Float32Image, ImageError
from enhance.params import DFactor, EnhanceParams
from enhance.pixel_block import BINS
from enhance.redness import blood_share, grey_of
from enhance.result import EnhanceResult
from enhance.rows import sums_of
from enhance.saturation import pull
from enhance.shown import Pixels, Shown
from enhance.statistics import LiveStatistics, Statistics, from_sums, require_classes
from enhance.stream import Stream
from enhance.vessel_density import (
    NOTHING,
    Spared,
    background,
    blood_density,
    middle_absorbed,
    middle_density,
)
from enhance.vessel_first_pass import SUBSAMPLE, TASK, first_pass
from enhance.vessel_second_pass import ABSORPTION, second_pass


@dataclass(
    frozen=True,
    kw_only=True,
    config=ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True),
)
class VesselParams:
    """Parameters of the preset `vessel`, with their ranges; each is described below its field.

    Raises:
        pydantic.ValidationError: (a ValueError) a value out of its range.

    Example:
        >>> from enhance import VesselParams
        >>> VesselParams(strength=3.0).radius
        16
    """

    strength: Annotated[float, Interval(ge=0.0, le=4.0)] = 2.4
    """How much what looks like blood is darkened and reddened: 0 is off."""
    radius: Annotated[int, Interval(ge=2, le=128), Unit("px")] = 16
    """Structures wider than twice this are not changed."""
    shading: Annotated[float, Interval(ge=0.0, le=1.0)] = 0.5
    """Share of the darkness common to red and green that is treated as shadow, not blood."""
    coring: Annotated[float, Interval(ge=0.0, le=4.0)] = 1.5
    """Structures weaker than this many times the image's median density are hardly strengthened."""
    contrast: Annotated[float, Interval(ge=0.0, le=1.0)] = 0.0
    """How much all that is darker than the image's median, however wide, is darkened and reddened like
    vessels: 0 is off."""
    most_exposure: Annotated[float, Interval(ge=1.0, le=8.0)] = 6.0
    """Underexposed images are brightened at most so many times, and their noise with them: 1 is off."""
    least_redness: Annotated[float, Interval(ge=0.0, le=1.0)] = 0.2
    """In images less red than this, such as grey ones, vessels are darkened in their own hue, not reddened: 0
    reddens them in all."""
    spare_grey: Annotated[float, Interval(ge=0.0, le=2.0)] = 2.0
    """How far what is grey in red images, as text and metal, is left out of what is darkened and reddened: 0
    is off; above 1, what is faintly red, as metal beside tissue, is left out, too."""
    color_smoothing: Annotated[float, Interval(ge=0.0, le=1.0)] = 1.0
    """How much of the coarse noise of colour, as from cheap cameras, is smoothed away in images that have it:
    0 is off."""
    lift: Annotated[float, Interval(ge=0.0, le=1.0)] = 0.25
    """How much of the paper's brightening, Eq 1, is applied: 0 is off."""
    gamma: Annotated[float, Interval(ge=0.5, le=2.0)] = 0.95
    """Exponent applied to V afterwards: above 1 darkens the mid-tones; black and white stay."""
    d_factor: DFactor = 0.7
    """Multiplies d in Eq 11: smaller means more colour. 0 leaves saturation unchanged."""
    most_color: Annotated[float, Interval(ge=1.0, le=4.0)] = 1.4
    """Upper limit of the saturation gain, which is at least 1: greys and highlights keep their colour."""


VESSEL: Final = VesselParams()
TONE: Final = EnhanceParams(p=0.0, d_factor=0.0)
"""What is taken of the paper's method, but for z."""
MEAN_ABSORPTION: Final = float(ABSORPTION.mean())


def enhance_vessels(
    image: AnyImage,
    params: VesselParams = VESSEL,
    *,
    tissue_mask: AnyImage | None = None,
    statistics: Statistics | None = None,
    pixels: Pixels = "automatic",
) -> EnhanceResult:
    """Make vessels visible as if they held more blood (Beer-Lambert law), with colours close to the original.

    1. Noise of colour, not of brightness, is smoothed away. V never rises by that. An image nine tenths of
       which are darker than 96 of 255 grey levels is then exposed longer, up to `most_exposure` times.
    2. V: Eq 1 of the paper with part of its brightening, then `gamma`.
    3. S: Eqs 11 and 12 with the gain kept between 1 and `most_color`.
    4. What is narrow and absorbs green more than red is a density of blood: the top-hat (the image less its
       morphological opening, of radius `radius`) of `shading` log R - log G. Slow shading falls out, of
       steps between tissues little is left, and reflections count as what surrounds them. R, G and B are
       attenuated by it as haemoglobin does. Nothing gets brighter, so nothing saturates. In images as red as
       tissue in white light, what is grey or faintly red, as text and metal, is left out by `spare_grey`. By
       `contrast`, all that absorbs more than the image's median counts, too, wide areas, shadows and tools.
    5. The less red exceeds green in an image, from `least_redness` of its brightness on down to half of that,
       the more of this darkness is that of G alone, and the more are R, G and B attenuated alike, by the mean
       of what blood absorbs, and twice the noise left out: no hue is invented in images that are nearly
       grey, under other light than white, or where dyes or fluorescence are.
    6. Where more than a fifth of an image has red and green curve against each other, as no structure of
       tissue makes them, colours are noise in blotches: up to `color_smoothing` of the differences to luma
       become those of a surround 8 pixels wide first of all, and as much less is darkness common to red and
       green treated as shadow, since colours no longer tell thin vessels.

    For many images, or many parameters of one, a `VesselEnhancer` is faster.

    Args:
        image: (H, W), (H, W, 3) RGB in this order, or (H, W, 4) RGBA; types as of `enhance`.
        tissue_mask: as of `enhance`; the median density, too, is that of the kept pixels.
        statistics: of a clip, measured with any parameters; None: of this image.
        pixels: as of `enhance`.

    Raises:
        ImageError, TypeError: as `enhance`.

    Example:
        >>> import numpy as np
        >>> from enhance import enhance_vessels, vessel_contrast
        >>> image = np.full((96, 96, 3), (200, 120, 110), np.uint8)
        >>> vessel = np.zeros((96, 96), bool)
        >>> vessel[:, 46:50] = True
        >>> image[vessel] = 190, 100, 95
        >>> result = enhance_vessels(image)
        >>> vessel_contrast(result.image, vessel) > vessel_contrast(image, vessel)
        True
    """
    enhancer = VesselEnhancer()
    enhancer.show(image, tissue_mask, pixels=pixels)
    return enhancer.enhance(params, statistics=statistics)


class _View(NamedTuple):
    """How an image is looked at."""

    smoothing: float
    """Share of coarse noise of colour that is smoothed away."""
    shading: float
    exposure: float
    """So many times longer."""


@plain_dataclass(frozen=True, eq=False)
class _Found:
    """Of one image: what the first pass finds."""

    shown: Shown
    view: _View
    """Of `bright` and `absorbed`."""
    around: Float32Image
    """Of `colors_around`; empty unless noise is smoothed away."""
    bright: Float32Image
    """(H / 2, W / 2) V in blocks of 2 x 2 pixels, times the exposure."""
    absorbed: Float32Image
    """(H / 2, W / 2) natural logarithm of what green lacks beside red; in grey images, of darkness."""


class _Counts(NamedTuple):
    """Of one image, over the kept pixels, as they are or without coarse noise of colour."""

    shown: Shown
    smoothing: float
    histogram: NDArray[np.int64]
    """(256,) of V."""
    chroma: float
    """Sum of S."""


@plain_dataclass(frozen=True, eq=False)
class _Ground:
    """What structures stand out from, of one radius."""

    radius: int
    opened: Float32Image
    """Background of what is absorbed, see `vessel_density.background`."""
    middle: float
    """Median of the density before coring."""


class VesselEnhancer:
    """Show it an image, then enhance it as often as the parameters change; see `enhance_vessels`.

    A new strength, coring, lift, gamma, d-factor or colour limit does not look for structures again.
    Working memory is reused from image to image. Not thread-safe.

    Example:
        >>> import numpy as np
        >>> from enhance import VesselEnhancer, VesselParams
        >>> enhancer = VesselEnhancer()
        >>> enhancer.show(np.random.default_rng(0).integers(0, 200, (48, 64, 3), dtype=np.uint8))
        >>> [enhancer.enhance(VesselParams(strength=x)).image.shape for x in (1.0, 2.0)]
        [(48, 64, 3), (48, 64, 3)]
    """

    def __init__(self, live: LiveStatistics | None = None) -> None:
        """live: as of `Enhancer`."""
        self._stream = Stream(live)
        self._shown: Shown | None = None
        self._found: _Found | None = None
        self._counts: _Counts | None = None
        self._ground: _Ground | None = None

    def show(
        self, image: AnyImage, tissue_mask: AnyImage | None = None, *, pixels: Pixels = "automatic"
    ) -> None:
        """Take the next image; see `enhance_vessels` for all three. It must not change while it is in use.

        Raises:
            ImageError: an image, mask or field that cannot be used; the previous image is kept.
        """
        self._take(self._stream.next(Shown.of(image, tissue_mask, pixels), pixels))

    def _take(self, shown: Shown) -> None:
        self._shown, self._ground = shown, None

    def enhance(
        self, params: VesselParams = VESSEL, *, statistics: Statistics | None = None
    ) -> EnhanceResult:
        """The image that is shown, enhanced.

        Raises:
            ImageError: statistics that cannot be used, no pixel to measure, or no image shown.
            TypeError: `params` or `statistics` of another class.
        """
        require_classes(params, VesselParams, statistics)
        now = self._look_within(statistics)
        known = statistics or self._measured(now, params)
        view = _view(now, params, known.redness, known.color_noise, known.bright_level)
        found = self._found
        if found is None or found.shown is not now or found.view != view:
            found, _ = self._see(now, view, _nothing(now))
        ground = self._stand(found, params.radius)
        z = 1 - (1 - z_from_level(known.level)) * params.lift
        used = known.resolved(replace(TONE, z=z))
        return EnhanceResult(_drawn(params, used, found, ground), used, ())

    def _look_within(self, statistics: Statistics | None) -> Shown:
        """The shown image within its field of view, or that of the statistics."""
        if self._shown is None:
            raise ImageError("expected an image to be shown before it is enhanced")
        now = self._shown.within(statistics)
        if now is not self._shown:
            self._take(now)
        return now

    def _measured(self, now: Shown, params: VesselParams) -> Statistics:
        """Of the shown image as it is enhanced, smoothed if the stream is live."""
        # Nearly always it is seen so in the end.
        likely = _view(now, params, now.reds.share, now.opposites.share, None)
        counts = self._counts
        if counts is None or counts.shown is not now or counts.smoothing != likely.smoothing:
            _, counts = self._see(now, likely, now.spans)
            self._counts = counts
        sums = counts.histogram.cumsum(), counts.chroma, ()
        one = from_sums("image", *sums, None, now.reds, now.opposites, now.field)
        return self._stream.smoothed(one, counts.histogram)

    def _see(self, now: Shown, view: _View, counted: Spans) -> tuple[_Found, _Counts]:
        """The first pass, into the memory of the one before where that fits."""
        found, counts = _first_pass(now, view, counted, self._found)
        self._found, self._ground = found, None
        return found, counts

    def _stand(self, found: _Found, radius: int) -> _Ground:
        """What of it is not narrow."""
        ground, now = self._ground, found.shown
        if ground is None or ground.radius != radius:
            opened = background(found.absorbed, found.bright, radius)
            middle = middle_density(found.absorbed, opened, radius, now.spans, now.keep)
            ground = self._ground = _Ground(radius, opened, middle)
        return ground


def _strength_and_coring(params: VesselParams, share: float) -> tuple[float, float]:
    """Without the colour of blood, all three colours lose the mean of what it absorbs, and twice as much
    counts as noise, since none of them is spared it."""
    return params.strength * (share + (1 - share) * MEAN_ABSORPTION), params.coring * (2 - share)


def _drawn(params: VesselParams, used: Statistics, found: _Found, ground: _Ground) -> AnyImage:
    """The second pass."""
    now, view = found.shown, found.view
    share = 0.0 if now.is_grey else blood_share(used.redness, params.least_redness)
    strength, coring = _strength_and_coring(params, 1.0 if now.is_grey else share)
    noise = coring * ground.middle
    planes, middle = (found.absorbed, found.bright), 0.0
    if params.contrast > 0:
        middle = middle_absorbed(*planes, view.shading, now.spans, now.keep)
    of_all, spared = (params.contrast, middle, view.shading), _spared(now, params, used.redness)
    density = blood_density(*planes, ground.opened, ground.radius, noise, *of_all, spared)
    out = np.empty_like(now.pixels)
    second_pass(
        now.pixels,
        now.spans,
        found.around,
        np.float32(view.smoothing),
        np.float32(now.full),
        sums_of(now.pixels),
        vessel_curves.brightness(used.z, view.exposure),
        np.float32(view.exposure),
        density[None],
        vessel_curves.powers(params.gamma),
        np.float32(pull(used.saturation_mean, params.d_factor)),
        np.float32(params.most_color),
        np.float32(strength),
        np.float32(share),
        out,
    )
    return now.finished(out)


def _spared(now: Shown, params: VesselParams, redness: float | None) -> Spared:
    """Nothing in images that are hardly red, or not known to be, whatever `least_redness` is; their vessels
    would be lost."""
    if now.is_grey or redness is None:
        return NOTHING
    share = min(params.spare_grey, 1.0) * blood_share(redness, VESSEL.least_redness)
    return Spared(share, grey_of(redness, max(params.spare_grey - 1, 0.0)))


def _view(
    now: Shown, params: VesselParams, redness: float | None, noise: float | None, bright: float | None
) -> _View:
    """By what is measured: `Statistics.redness`, `color_noise` and `bright_level`."""
    times = exposure(bright, params.most_exposure)
    if now.is_grey:
        return _View(0.0, 0.0, times)
    smoothing = params.color_smoothing * coarse_share(noise)
    share = blood_share(redness, params.least_redness)
    return _View(smoothing, (1 - smoothing) * share * params.shading, times)


def _nothing(now: Shown) -> Spans:
    """Of no pixel: V above 1, as of an image that is exposed longer, is in no histogram."""
    return np.zeros((now.pixels.shape[0], 2), np.int32)


def _first_pass(now: Shown, view: _View, counted: Spans, before: _Found | None) -> tuple[_Found, _Counts]:
    """Into the memory of the one before where that fits, of pixels whose full scale is less by the exposure.

    So the floor of its logarithms is less, too, which hides what differs by few grey levels.
    """
    height, width = now.pixels.shape[:2]
    low = -(-height // SUBSAMPLE), -(-width // SUBSAMPLE)
    around = before.around if before is not None and before.shown is now else NO_COLORS
    if view.smoothing > 0 and around.size == 0:
        around = colors_around(now.pixels, now.full)
    if before is not None and before.bright.shape == low:
        bright, absorbed = before.bright, before.absorbed
    else:
        bright, absorbed = np.empty(low, np.float32), np.empty(low, np.float32)
    tasks = -(-height // TASK)
    histograms, chroma = np.empty((tasks, BINS), np.int64), np.empty(tasks)
    first_pass(
        now.pixels,
        now.keep,
        counted,
        now.spans,
        around,
        np.float32(view.smoothing),
        np.float32(now.full / view.exposure),
        sums_of(now.pixels),
        np.float32(view.shading),
        bright,
        histograms,
        chroma,
        absorbed,
    )
    counts = _Counts(now, view.smoothing, histograms.sum(axis=0), float(chroma.sum()))
    return _Found(now, view, around, bright, absorbed), counts
