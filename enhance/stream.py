"""What the images of a live stream have in common: smoothed statistics, a steady field of view, and cuts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from enhance.field_tracker import FieldTracker
from enhance.shown import Pixels, Shown
from enhance.statistics import LiveStatistics, Statistics


class CutWatch:
    """Tells another scene, such as after the lens was wiped, from a flash.

    A scene is another one once two images in a row differ from it and not from each other.
    """

    def __init__(self) -> None:
        self._scene: NDArray[np.float64] | None = None
        self._odd: NDArray[np.float64] | None = None

    def sees_cut(self, histogram: NDArray[np.int64], cut: float) -> bool:
        """Whether the next image, with this histogram of V, is the second one of another scene.

        cut: distance of two histograms from which on they are of two scenes, in grey levels.
        """
        shares = np.cumsum(histogram) / max(int(histogram.sum()), 1)
        is_other = self._scene is not None and self._apart(shares, self._scene) >= cut
        is_cut = is_other and self._odd is not None and self._apart(shares, self._odd) < cut
        if is_other and not is_cut:
            self._odd = shares
        else:
            self._scene, self._odd = shares, None
        return is_cut

    @staticmethod
    def _apart(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
        """How far a pixel's V moves on average from one distribution to the other (Wasserstein distance)."""
        return float(np.abs(one - other).sum())


class Stream:
    """Follows one stream: what each image is enhanced with depends on those before. Without `live`, each
    image stands alone."""

    def __init__(self, live: LiveStatistics | None) -> None:
        self._live = live
        self._tracker, self._watch = FieldTracker(), CutWatch()
        self._before: Statistics | None = None
        self._last: Statistics | None = None
        self._looked = False

    def next(self, shown: Shown, pixels: Pixels) -> Shown:
        """The next image, within the field of view of the stream where that is looked for."""
        self._before, self._looked = self._last, False
        if self._live is None or pixels != "automatic":
            return shown
        field = self._tracker.follow(shown.picture)
        return replace(shown, wanted=field, field=field)

    def smoothed(self, measured: Statistics, histogram: NDArray[np.int64]) -> Statistics:
        """What is used of the image in place of what was measured on it; z and P are to be resolved again."""
        if self._live is None:
            return measured
        if not self._looked:
            self._looked = True
            if self._watch.sees_cut(histogram, self._live.cut):
                self._before = None
        self._last = self._live.follow(self._before, measured)
        return self._last
