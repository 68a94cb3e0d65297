"""Global statistics of Eqs 2, 9 and 12, of one image or pooled over a clip."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator

from enhance import brightness, detail
from enhance.changed import changed
from enhance.color_noise import NO_OPPOSITES, Opposites
from enhance.exposure import bright_level
from enhance.field import FieldOfView
from enhance.image import ImageError
from enhance.params import EnhanceParams
from enhance.redness import NO_REDS, Reds
from enhance.saturation import color_share

Scope = Literal["image", "clip", "live"]


def _known(field: Any) -> Any:
    """Of a record's field of view what is known: what another version may say besides is passed over."""
    if not isinstance(field, dict):
        return field
    known = {name: value for name, value in field.items() if name in FieldOfView.__dataclass_fields__}
    parts = field.get("parts")
    return known | {"parts": tuple(map(_known, parts))} if isinstance(parts, list | tuple) else known


@dataclass(frozen=True, kw_only=True)
class Statistics:
    """What the equations need from the whole image, and what follows from it.

    `level`, `saturation_mean` and `sigmas` are measured; `z` and `p` follow from them and the parameters
    (`resolved`).

    Example:
        >>> import numpy as np
        >>> from enhance import measure
        >>> used = measure([np.full((32, 32, 3), 100, np.uint8)])
        >>> used.level, used.z, used.saturation_mean  # L of Eq 2; z; S_m of Eq 12
        (100, 0.5, 0.0)
    """

    level: float
    """L of Eq 2, 0 to 255; a whole number unless smoothed over time."""
    z: float
    """Used in Eq 1, in [0, 1]."""
    saturation_mean: float
    """S_m of Eq 12, in [0, 1]; 0 for grey images."""
    sigmas: tuple[float, ...]
    """Standard deviation of each scale's Q in grey levels (Eq 9); none of an image for which P was set."""
    p: tuple[float, ...]
    """Used in Eq 7, one for each scale."""
    scope: Scope
    """Measured on this image, pooled over a clip, or smoothed over the images so far of a live stream."""
    chroma_snr: float | None = None
    """Colour over its noise; None: not measured, as of grey images, or of an image for which d was set."""
    color: float = 1.0
    """Share of the change of saturation of Eqs 11 and 12 in use, in [0, 1]: 1 where d was set; times the
    strength."""
    bright_level: float | None = None
    """Grey level of V that nine tenths of the pixels do not exceed, 0 to 255: that of underexposed images is
    low. None: not measured, as before 0.9.0."""
    redness: float | None = None
    """By how much red exceeds green, as a share of V, over all pixels but clipped ones. None: not measured,
    as before 0.10.0, or of grey images."""
    color_noise: float | None = None
    """Share of places where red and green curve against each other, as coarse noise of colour makes them; see
    `color_noise`. None: not measured, as before 0.13.0, or of images that are grey or too dark."""
    field: Annotated[FieldOfView | None, BeforeValidator(_known)] = None
    """Where it was measured, and is to be used; None: all pixels."""

    def __post_init__(self) -> None:
        """Raises ImageError: measurements that are not finite."""
        levels = self.level, self.bright_level or 0.0
        colors = self.saturation_mean, self.chroma_snr or 0.0, self.redness or 0.0, self.color_noise or 0.0
        measured = (*levels, *colors, *self.sigmas)
        if not all(map(math.isfinite, (*measured, self.z, *self.p, self.color))):
            raise ImageError(f"expected statistics of finite numbers, got {self}")

    def resolved(self, params: EnhanceParams) -> Statistics:
        """The same measurements with z and P as `params` ask: set by the user, or Eqs 2 and 9; times its
        strength.

        Raises:
            ImageError: measured with another number of scales.
        """
        if params.p is None and len(self.sigmas) != len(params.radii):
            raise ImageError(
                f"expected statistics of {len(params.radii)} scales (radii {params.radii}), "
                f"got {len(self.sigmas)}; measure again with these radii"
            )
        z = brightness.z_from_level(self.level) if params.z is None else params.z
        if isinstance(params.p, tuple):
            p = params.p
        elif params.p is not None:
            p = (params.p,) * len(params.radii)
        else:
            p = tuple([detail.exponent(sigma, params.p_form) for sigma in self.sigmas])
        color = color_share(self.saturation_mean, self.chroma_snr) if params.d_factor is None else 1.0
        if params.strength == 1:
            return changed(self, z=z, p=p, color=color)
        return changed(
            self,
            z=max(0.0, 1 - params.strength * (1 - z)),
            p=tuple([params.strength * one for one in p]),
            color=min(1.0, params.strength * color),
        )


def require_classes(params: object, expected: type, statistics: object = None) -> None:
    """Raises TypeError: parameters of another class, or statistics that are none."""
    if not isinstance(params, expected):
        raise TypeError(f"expected params to be {expected.__name__}, got {type(params).__name__}")
    if statistics is not None and not isinstance(statistics, Statistics):
        raise TypeError(f"expected statistics to be Statistics, got {type(statistics).__name__}")


@dataclass(frozen=True, eq=False)
class Tally:
    """Sums that statistics follow from; those of several images add up with `+`."""

    count: int
    """Pixels."""
    histogram: NDArray[np.int64]
    """(256,) of V."""
    saturation: float
    """Sum of S."""
    means: NDArray[np.float64]
    """(n_scales,) mean of Q."""
    squares: NDArray[np.float64]
    """(n_scales,) sum of (Q - mean)^2."""
    colored: int = 0
    """Pixels of images whose colour over noise is known."""
    snr: float = 0.0
    """Its mean over these pixels."""
    reds: Reds = NO_REDS
    """Of images with colours."""
    opposites: Opposites = NO_OPPOSITES
    """Of images with colours."""

    @property
    def sigmas(self) -> tuple[float, ...]:
        """Standard deviation of each scale's Q in grey levels."""
        return tuple(255 * float(sigma) for sigma in np.sqrt(self.squares / max(self.count, 1)))

    def __add__(self, other: Tally) -> Tally:
        """Counts and sums add; variances by Chan, Golub and LeVeque, 1979, without cancellation."""
        count = self.count + other.count
        share = other.count / count if count else 0.0
        colored = self.colored + other.colored
        share_colored = other.colored / colored if colored else 0.0
        apart = other.means - self.means
        return Tally(
            count=count,
            histogram=self.histogram + other.histogram,
            saturation=self.saturation + other.saturation,
            means=self.means + apart * share,
            squares=self.squares + other.squares + apart**2 * self.count * share,
            colored=colored,
            snr=self.snr + (other.snr - self.snr) * share_colored,
            reds=Reds(self.reds.red + other.reds.red, self.reds.light + other.reds.light),
            opposites=Opposites(*np.add(self.opposites, other.opposites).tolist()),
        )

    def statistics(self, params: EnhanceParams, scope: Scope) -> Statistics:
        """The statistics of all pixels counted.

        Raises:
            ImageError: no pixel was.
        """
        snr = self.snr if self.colored else None
        sums = self.histogram.cumsum(), self.saturation, self.sigmas
        return from_sums(scope, *sums, snr, self.reds, self.opposites).resolved(params)


def from_sums(
    scope: Scope,
    cumulative: NDArray[np.int64],
    saturation: float,
    sigmas: tuple[float, ...],
    chroma_snr: float | None = None,
    reds: Reds = NO_REDS,
    opposites: Opposites = NO_OPPOSITES,
    field: FieldOfView | None = None,
) -> Statistics:
    """Statistics of pixels with this cumulative histogram of V of which `saturation` is the sum of S; z and P
    are to be resolved.

    Raises:
        ImageError: there is no pixel.
    """
    count = int(cumulative[-1])
    if count == 0:
        raise ImageError("expected at least one pixel to measure, got none: tissue_mask or alpha hides all")
    return Statistics(
        level=brightness.level(cumulative),
        z=0.0,
        saturation_mean=saturation / count,
        sigmas=sigmas,
        p=(),
        scope=scope,
        chroma_snr=chroma_snr,
        bright_level=bright_level(cumulative),
        redness=reds.share,
        color_noise=opposites.share,
        field=field,
    )


@dataclass(frozen=True, kw_only=True)
class LiveStatistics:
    """Statistics of a live stream: each image moves them part of the way, so that nothing flickers.

    Raises:
        ValueError: a half-life below 0, or none, or a cut of 0 or less.

    Example:
        >>> import numpy as np
        >>> from enhance import Enhancer, LiveStatistics
        >>> enhancer = Enhancer(LiveStatistics(half_life=1))
        >>> for level in (50, 70, 70, 200, 200):
        ...     enhancer.show(np.full((32, 32, 3), level, np.uint8))
        ...     print(enhancer.enhance().statistics.level)
        50
        60.0
        65.0
        132.5
        200
    """

    half_life: float = 12.0
    """Images after which half of a change has been followed; 0 follows at once."""
    cut: float = 24.0
    """Grey levels by which V moves on average from one scene to another: with the second image of another
    scene the statistics begin anew."""

    def __post_init__(self) -> None:
        if not 0 <= self.half_life < np.inf:
            raise ValueError(f"expected a half_life of 0 or more images, got {self.half_life}")
        if not self.cut > 0:
            raise ValueError(f"expected a cut of more than 0 grey levels, got {self.cut}")

    def follow(self, before: Statistics | None, measured: Statistics) -> Statistics:
        """`before` moved towards what was `measured` on the next image; z and P are to be resolved again."""
        if before is None:
            return replace(measured, scope="live")
        keep = 0.5 ** (1 / self.half_life) if self.half_life > 0 else 0.0

        known = len(before.sigmas) == len(measured.sigmas)

        def blend(old: float, new: float) -> float:
            return new + keep * (old - new)

        def blend_known(old: float | None, new: float | None) -> float | None:
            return new if old is None or new is None else blend(old, new)

        return replace(
            measured,
            level=blend(before.level, measured.level),
            saturation_mean=blend(before.saturation_mean, measured.saturation_mean),
            sigmas=tuple(map(blend, before.sigmas, measured.sigmas)) if known else measured.sigmas,
            chroma_snr=blend_known(before.chroma_snr, measured.chroma_snr),
            bright_level=blend_known(before.bright_level, measured.bright_level),
            redness=blend_known(before.redness, measured.redness),
            color_noise=blend_known(before.color_noise, measured.color_noise),
            scope="live",
        )
