"""Halos in grey levels: how far a method overshoots beside highlights and strong edges, and nowhere else.

Pixels whose alpha is 0 count in neither measure.
"""

from __future__ import annotations

import math
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance.image import AnyImage, BoolImage
from enhance.measured_pixels import check_sizes, kept
from enhance.metrics import grey_levels
from enhance.ridges import glare

Grey = NDArray[np.float64]

NEAREST: Final = 2.0
"""Pixels from a highlight or an edge; closer ones are its own blur."""
NEAR: Final = 10.0
"""Up to here, halos are looked for."""
FAR: Final = 20.0
"""Up to here, pixels show what the same method does where there is no halo, or less of one."""
BLOCK: Final = 64
"""Pixels of a block's side, within which pixels are compared: a method may differ from place to place."""
EDGE_SIGMA: Final = 2.0
STEEP: Final = 8
"""Grey levels per pixel: the slope of a step of 40, blurred by EDGE_SIGMA."""


def highlight_halo(image: AnyImage, original: AnyImage, *, tissue_mask: BoolImage | None = None) -> float:
    """How much darker `image` is beside specular highlights than a little farther away, in grey levels.

    A halo by overshoot (Trentacoste et al., Computer Graphics Forum 31(2), 2012) is a change that depends on
    the distance to an edge, not on the grey level. So the change of grey (BT.601) at 2 to 10 pixels from
    highlights (`enhance.ridges.glare` of `original`) is compared with that at 10 to 20 pixels where
    `original` has the same whole grey level, within blocks of 64 x 64 pixels: the mean over the near pixels
    for which there is such a far one. A tone curve of grey has no halo, whatever its slope. Negative: a glow.
    Where the far pixels lie in the halo, too, as of very wide filters, less is found. NaN: no highlight, or
    nothing to compare.

    Args:
        tissue_mask: (H, W), True = keep: pixels that are compared. Leave out vessels where vessels are meant
            to change.

    Raises:
        ImageError: images or a mask of different sizes.

    Example:
        >>> import numpy as np
        >>> from enhance import highlight_halo, unsharp
        >>> image = np.full((64, 64, 3), 100, np.uint8)
        >>> image[28:36, 28:36] = 250
        >>> highlight_halo(image, image), highlight_halo(unsharp(image), image) > 3
        (0.0, True)
    """
    before, after, keep = _greys(image, original, tissue_mask)
    distance = _distance(glare(original))
    return _overshoot(before - after, _alike(before), distance, keep & (distance > 0))


def edge_halo(image: AnyImage, original: AnyImage, *, tissue_mask: BoolImage | None = None) -> float:
    """As `highlight_halo`, beside strong edges: darker on the dark side and brighter on the bright one.

    Edges are Canny's (IEEE PAMI 8(6), 1986): the crests of the slope of the grey of `original`, blurred by 2
    pixels, where it is at least 8 grey levels per pixel, as at steps of 40: folds, tools, the rim of the
    view. The dark side is darker than the nearest edge. What lies within 20 pixels of highlights or pixels
    whose alpha is 0 is left out.

    Args:
        tissue_mask: as of `highlight_halo`; edges may lie outside.

    Raises:
        ImageError: images or a mask of different sizes.

    Example:
        >>> import numpy as np
        >>> from enhance import edge_halo, unsharp
        >>> image = np.full((64, 128, 3), 80, np.uint8)
        >>> image[:, 64:] = 160
        >>> edge_halo(image // 2, image), edge_halo(unsharp(image), image) > 3
        (0.0, True)
    """
    before, after, keep = _greys(image, original, tissue_mask)
    hidden = ~kept(original)
    keep &= _distance(glare(original) | hidden) > FAR
    edges, level = _edges(before, _distance(hidden) > NEAR)
    is_dark = before < level
    change = np.where(is_dark, before - after, after - before)
    return _overshoot(change, 2 * _alike(before) + is_dark, _distance(edges), keep)


def _greys(
    image: AnyImage, original: AnyImage, tissue_mask: BoolImage | None
) -> tuple[Grey, Grey, BoolImage]:
    """Of the original and the image, 0 to 255; and which pixels count."""
    before, after = grey_levels(original), grey_levels(image)
    check_sizes(after, before)
    return before, after, kept(original, tissue_mask) & kept(image)


def _distance(where: BoolImage) -> NDArray[np.float32]:
    """Pixels to the nearest one that is True; very far where there is none."""
    return np.asarray(cv2.distanceTransform((~where).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE))


def _edges(grey: Grey, within: BoolImage) -> tuple[BoolImage, Grey]:
    """Strong edges within, and for every pixel the level in the middle of the nearest one."""
    smooth = cv2.GaussianBlur(grey, (0, 0), EDGE_SIGMA)
    # Scharr's kernel answers 32 to a slope of 1.
    dx, dy = (np.rint(cv2.Scharr(smooth, cv2.CV_64F, *along)).astype(np.int16) for along in ((1, 0), (0, 1)))
    edges = within & (np.asarray(cv2.Canny(dx, dy, 32 * STEEP, 32 * STEEP, L2gradient=True)) > 0)
    _, nearest = cv2.distanceTransformWithLabels(
        (~edges).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    level = np.zeros(int(nearest.max()) + 1)
    level[nearest[edges]] = np.asarray(smooth)[edges]
    return edges, level[nearest]


def _alike(grey: Grey) -> NDArray[np.int64]:
    """(H, W) numbers that are the same for pixels of one whole grey level in one block."""
    rows, columns = (np.arange(size) // BLOCK for size in grey.shape)
    block = rows[:, None] * (columns[-1] + 1) + columns
    return np.asarray(256 * block + np.rint(grey).astype(np.int64))


def _overshoot(
    change: Grey, alike: NDArray[np.int64], distance: NDArray[np.float32], keep: BoolImage
) -> float:
    """Mean change of near pixels beyond that of far ones that are alike; (H, W) each."""
    near = keep & (distance > NEAREST) & (distance <= NEAR)
    far = keep & (distance > NEAR) & (distance <= FAR)
    length = int(alike.max()) + 1
    count, total = (np.bincount(alike[far], weights, length) for weights in (None, change[far]))
    beside = near & (count[alike] > 0)
    if not beside.any():
        return math.nan
    usual = total[alike[beside]] / count[alike[beside]]
    return float(np.mean(change[beside] - usual))
