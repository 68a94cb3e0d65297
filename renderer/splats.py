"""Splats: what leaves training and is drawn. Numpy, activated values, one moment in time."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from renderer.harmonics import BANDS, seen_colors

Float32Array = NDArray[np.float32]
RenderMode = Literal["default", "mip"]
"""How a splat narrower than a pixel is drawn, the `SplatRenderMode` of files: by "default" at its full
opacity; by "mip" (anti-aliased, Mip-Splatting) at sqrt(det C / det(C + 0.3 I)) of it, C being its covariance
on the screen in px^2, which makes up for the low-pass filter. Each is right for models so trained."""
Shape = Literal["soft", "ellipsoid", "point"]
"""How a splat is drawn: as the Gaussian it is, or as an opaque body, which shows how a model is built."""


def require_drawable(near: float, mode: str) -> None:
    """Raises ValueError: a near plane that is not in front of the camera, or an unknown mode."""
    if not near > 0:
        raise ValueError(f"near must be > 0, got {near}")
    require_mode(mode)


def require_mode(mode: str) -> None:
    """Raises ValueError: an unknown mode."""
    if mode not in get_args(RenderMode):
        raise ValueError(f"mode must be {' or '.join(get_args(RenderMode))}, got {mode!r}")


@dataclass(frozen=True, eq=False)
class Splats:
    """N Gaussians in world space, C-contiguous float32, linear ("activated") values.

    means (N, 3); quats (N, 4) wxyz, any non-zero length; scales (N, 3) standard deviations > 0;
    opacities (N,) in [0, 1]; colors (N, 3) display-referred RGB, nominally [0, 1]; harmonics (N, B, 3)
    what a direction adds to them, B = 0, 3, 8 or 15, see harmonics.py. Of values that
    are not finite `render` leaves the splat out, and `SplatView` refuses them.

    Raises:
        ValueError: shapes that do not agree, or colours of bytes. The message names the field.

    Example:
        >>> import numpy as np
        >>> from renderer import Splats
        >>> splats = Splats(
        ...     means=np.float32([[0, 0, 5]]),
        ...     quats=np.float32([[1, 0, 0, 0]]),
        ...     scales=np.full((1, 3), 0.3, np.float32),
        ...     opacities=np.float32([0.9]),
        ...     colors=np.float32([[0.8, 0.2, 0.2]]),
        ... )
        >>> len(splats), splats.harmonics.shape
        (1, (1, 0, 3))
    """

    means: Float32Array
    quats: Float32Array
    scales: Float32Array
    opacities: Float32Array
    colors: Float32Array
    harmonics: Float32Array = field(default_factory=lambda: np.zeros((0, 0, 3), np.float32))

    def __post_init__(self) -> None:
        count, bands = len(self.means), self.harmonics.shape[1]
        if bands == 0:
            object.__setattr__(self, "harmonics", np.zeros((count, 0, 3), np.float32))
        if bands not in BANDS:
            raise ValueError(f"Splats.harmonics must have one of {BANDS} functions, got {bands}")
        if getattr(self.colors, "dtype", None) == np.uint8:
            raise ValueError("Splats.colors must be floats in [0, 1], got uint8: divide by 255")
        shapes = {"means": (3,), "quats": (4,), "scales": (3,), "opacities": (), "colors": (3,)}
        for name, tail in (shapes | {"harmonics": (bands, 3)}).items():
            value = np.ascontiguousarray(getattr(self, name), dtype=np.float32)
            if value.shape != (count, *tail):
                raise ValueError(f"Splats.{name} must have shape {(count, *tail)}, got {value.shape}")
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return len(self.means)

    def seen_from(self, center: NDArray[np.float64]) -> Splats:
        """The splats in the colours that a camera at `center` (3,) sees, without harmonics."""
        if not self.harmonics.size:
            return self
        colors = seen_colors(self.means, self.harmonics, self.colors, center)
        return replace(self, colors=colors, harmonics=self.harmonics[:, :0])
