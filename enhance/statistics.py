"""Global statistics of Eqs 2, 9 and 12, of one image or pooled over a clip."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from enhance import brightness, detail
from enhance.image import BoolImage, Float32Image, ImageError
from enhance.params import EnhanceParams

Scope = Literal["image", "clip"]


@dataclass(frozen=True, kw_only=True)
class Statistics:
    """What the equations take from the whole image, and what follows from it.

    `level`, `saturation_mean` and `sigmas` are measured; `z` and `p` follow from them and the parameters
    (`resolved`).
    """

    level: float
    """L of Eq 2, 0 to 255; a whole number unless smoothed over time."""
    z: float
    """Used in Eq 1, in [0, 1]."""
    saturation_mean: float
    """S_m of Eq 12, in [0, 1]; 0 for grey images."""
    sigmas: tuple[float, ...]
    """Standard deviation of each scale's Q in grey levels (Eq 9)."""
    p: tuple[float, ...]
    """Used in Eq 7, one for each scale."""
    scope: Scope
    """Measured on this image, or pooled over a clip."""

    def resolved(self, params: EnhanceParams) -> Statistics:
        """The same measurements with z and P as `params` ask: set by the user, or Eqs 2 and 9.

        Raises:
            ImageError: measured with another number of scales.
        """
        if len(self.sigmas) != len(params.radii):
            raise ImageError(
                f"expected statistics of {len(params.radii)} scales (radii {params.radii}), "
                f"got {len(self.sigmas)}; measure again with these radii"
            )
        z = brightness.z_from_level(self.level) if params.z is None else params.z
        if isinstance(params.p, tuple):
            p = params.p
        elif params.p is not None:
            p = (params.p,) * len(self.sigmas)
        else:
            p = tuple(detail.exponent(sigma, params.p_form) for sigma in self.sigmas)
        return replace(self, z=z, p=p)


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

    def __add__(self, other: Tally) -> Tally:
        """Counts and sums add; variances by Chan, Golub and LeVeque, 1979, without cancellation."""
        count = self.count + other.count
        share = other.count / count if count else 0.0
        apart = other.means - self.means
        return Tally(
            count=count,
            histogram=self.histogram + other.histogram,
            saturation=self.saturation + other.saturation,
            means=self.means + apart * share,
            squares=self.squares + other.squares + apart**2 * self.count * share,
        )

    def statistics(self, params: EnhanceParams, scope: Scope) -> Statistics:
        """The statistics of all pixels counted.

        Raises:
            ImageError: no pixel was.
        """
        if self.count == 0:
            raise ImageError(
                "expected at least one pixel to measure, got none: tissue_mask or alpha hides all"
            )
        measured = Statistics(
            level=brightness.level(self.histogram),
            z=0.0,
            saturation_mean=self.saturation / self.count,
            sigmas=tuple(255 * float(sigma) for sigma in np.sqrt(self.squares / self.count)),
            p=(),
            scope=scope,
        )
        return measured.resolved(params)


def tally(
    value: Float32Image, chroma: Float32Image | None, filtered: tuple[Float32Image, ...], keep: BoolImage
) -> Tally:
    """Sums over the kept pixels of one image: of its V, its S (None for grey) and each scale's Q."""
    count = int(np.count_nonzero(keep))
    kept = [np.asarray(q[keep], dtype=np.float64) for q in filtered]
    return Tally(
        count=count,
        histogram=brightness.value_histogram(value, keep),
        saturation=0.0 if chroma is None else float(np.sum(chroma[keep], dtype=np.float64)),
        means=np.array([q.mean() if count else 0.0 for q in kept]),
        squares=np.array([q.var() * count if count else 0.0 for q in kept]),
    )
