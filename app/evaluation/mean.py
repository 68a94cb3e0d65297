"""The mean of measures, some of which may be undefined."""

from __future__ import annotations

import math
from collections.abc import Iterable


def mean_of_finite(values: Iterable[float | None]) -> float | None:
    """None when nothing finite was measured; what is None, NaN or infinite is left out."""
    finite = [value for value in values if value is not None and math.isfinite(value)]
    return math.fsum(finite) / len(finite) if finite else None
