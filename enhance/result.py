"""What comes out of the enhancement."""

from __future__ import annotations

from dataclasses import dataclass

from enhance.image import AnyImage
from enhance.statistics import Statistics


@dataclass(frozen=True)
class Omission:
    """One stage that this image does not need and that is therefore left out.

    Example:
        >>> import numpy as np
        >>> from enhance import enhance
        >>> first, *_ = enhance(np.full((32, 32), 0.5)).omitted
        >>> first.what, first.why, first.error
        ('saturation', 'the image is grey', 0.0)
    """

    what: str
    why: str
    error: float
    """Bound on the difference that it makes, in grey levels of the result."""


@dataclass(frozen=True, eq=False)
class EnhanceResult:
    """An enhanced image and everything needed to reproduce it.

    Example:
        >>> import numpy as np
        >>> from enhance import enhance
        >>> image = np.random.default_rng(0).uniform(0.1, 0.4, (32, 32, 3)).astype(np.float32)
        >>> result = enhance(image)
        >>> again = enhance(image, statistics=result.statistics)
        >>> result.image.dtype, bool(np.allclose(again.image, result.image, atol=1e-5))
        (dtype('float32'), True)
    """

    image: AnyImage
    """Shape and type of the input."""
    statistics: Statistics
    """What was used."""
    omitted: tuple[Omission, ...]
