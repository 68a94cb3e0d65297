"""What a file of splats holds, whatever its format."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from renderer.harmonics import BANDS
from renderer.raw_gaussians import RawGaussians
from renderer.splats import RenderMode

PER_COLOR: Final = 0.28209479177387814
"""Colour that a spherical harmonic coefficient of degree 0 makes; 0.5 is added."""
FARTHEST: Final = 1e14
"""Positions and sizes: a camera that sees all of them can still stand before them."""
MOST_LOGIT: Final = np.float32(80.0)
"""Opacities of 0 and 1 become those of this logit, which float32 does not tell from them."""
FUNCTIONS: Final = (*BANDS, 24)
"""Harmonics by degree. Files hold them to degree 4, of which nothing here draws more than three."""


class SplatFileError(ValueError):
    """A splat file cannot be read: what was expected and what came.

    Example:
        >>> from pathlib import Path
        >>> from renderer import SplatFileError, read_splats
        >>> try:
        ...     read_splats(Path("nothing-here.ply"))
        ... except SplatFileError as error:
        ...     print(error)
        expected a splat file, got none that can be read (No such file or directory): nothing-here.ply
    """


@dataclass(frozen=True, eq=False)
class SplatFile:
    """Gaussians at rest, in the axes of the file's convention turned to x right, y down, z forward.

    Example:
        >>> import numpy as np
        >>> from renderer import RawGaussians, SplatFile
        >>> raw = RawGaussians(
        ...     means=np.float32([[0, 0, 5], [1, 0, 5]]),
        ...     quats=np.float32([[1, 0, 0, 0]] * 2),
        ...     log_scales=np.log(np.full((2, 3), 0.3, np.float32)),
        ...     opacity_logits=np.float32([0, 2]),
        ...     colors=np.float32([[0.8, 0.2, 0.2], [0.2, 0.8, 0.2]]),
        ...     harmonics=np.zeros((2, 0, 3), np.float32),
        ... )
        >>> file = SplatFile(raw)
        >>> file.mode, file.notices
        ('default', ())
    """

    raw: RawGaussians
    mode: RenderMode = "default"
    notices: tuple[str, ...] = ()
    """What had to be repaired."""


def colors_of(coefficients: NDArray[np.float32]) -> NDArray[np.float32]:
    """(N, 3) of coefficients of degree 0."""
    return np.asarray(0.5 + PER_COLOR * coefficients.astype(np.float64), np.float32)


def coefficients_of(colors: NDArray[np.float32]) -> NDArray[np.float64]:
    """(N, 3) of degree 0 that make these colours."""
    return (colors.astype(np.float64) - 0.5) / PER_COLOR


def repaired(raw: RawGaussians, mode: RenderMode = "default", degree: int = 0) -> SplatFile:
    """Without the rows that cannot be drawn: values that are not finite, places and sizes out of sight.
    `degree`: of the harmonics in the file."""
    good = drawable(raw)
    logits = np.clip(raw.opacity_logits, -MOST_LOGIT, MOST_LOGIT)
    lost = np.all(raw.quats == 0, axis=1)
    quats = np.where(lost[:, None], np.array([1, 0, 0, 0], np.float32), raw.quats)
    raw = replace(raw, opacity_logits=logits, quats=quats)
    notices = []
    if count := int(np.count_nonzero(~good)):
        notices.append(
            f"{count} of {len(raw)} splats have a value that is not finite or too large, or no size, "
            "and are left out"
        )
    if count := int(np.count_nonzero(lost & good)):
        notices.append(f"{count} of {len(raw)} splats have no rotation and are read as unrotated")
    if degree >= len(BANDS):
        notices.append(f"colours by direction are read to degree {len(BANDS) - 1} of {degree}")
    return SplatFile(raw if good.all() else raw.rows(np.flatnonzero(good)), mode, tuple(notices))


def drawable(raw: RawGaussians) -> NDArray[np.bool_]:
    """(N,) rows whose values are finite, but logits of any size, with places and sizes within sight."""
    with np.errstate(over="ignore", invalid="ignore"):
        scales = np.exp(raw.log_scales)
    values = (raw.means, raw.quats, scales, raw.colors, *raw.harmonics.transpose(1, 0, 2))
    finite = [np.isfinite(value).all(axis=1) for value in values]
    near = [(np.abs(value) <= FARTHEST).all(axis=1) for value in (raw.means, scales)]
    good: NDArray[np.bool_] = np.all(
        [*finite, *near, (scales > 0).all(axis=1), ~np.isnan(raw.opacity_logits)], axis=0
    )
    return good


def require_drawable(raw: RawGaussians) -> None:
    """Raises ValueError: rows that readers leave out, of which formats with bounds lose others too."""
    lost = np.flatnonzero(~drawable(raw))
    if len(lost):
        raise ValueError(
            f"expected splats of finite values and a size, nearer and smaller than {FARTHEST:g}, "
            f"got {len(lost)} of {len(raw)} without, the first in row {lost[0]}"
        )
