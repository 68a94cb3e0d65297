"""Where vessels are, for measuring: dark ridges of green at several scales, and one fixed mask of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance.image import AnyImage, BoolImage, Float32Image, ImageError, Picture, read_mask, read_picture
from enhance.measured_pixels import channels, green, seen, unit
from enhance.metrics import disc, scaled

SIGMAS: Final = (1.5, 2.5, 4.0)
"""Gaussian scales in pixels: vessels some 3 to 12 pixels wide."""
SHARE: Final = 0.05
"""Of the tissue that the fixed mask takes."""
MARGIN: Final = 12
"""Pixels beside the surround and along the border that are no tissue: edges look like vessels."""
GLARE: Final = 235 / 255
"""R, G and B all above: a specular highlight."""
GLARE_MARGIN: Final = 8
"""Pixels beside a highlight that are left out: lines between highlights only look dark."""
CREASE: Final = 0.5
"""Of the green around; what is darker is no vessel."""
CREASE_RADIUS: Final = 12
"""Pixels: as wide as the widest lines of the mask, on either side."""
LEAST_AREA: Final = 40
"""Pixels: smaller specks of a mask are noise."""
SHADOW: Final = 0.1
"""Share of the mean green that is added to the blurred green, so that noise in the dark is no ridge."""

FINEST: Final = 0.7
"""Pixels, of the scales for a small image: a line of one pixel is no wider."""
LEAST_SIGMA: Final = 0.05
"""Pixels: of a narrower Gaussian nothing is left beside its middle."""


def vesselness(image: AnyImage, sigmas: Sequence[float] = SIGMAS) -> Float32Image:
    """Ridge strength of dark lines, (H, W) >= 0; 0 on a constant image.

    At each scale the larger eigenvalue of the Hessian of green (blurred by a Gaussian, times sigma^2 as in
    Lindeberg, IJCV 30(2), 1998), less the other eigenvalue's size, which spots have, and less sigma times the
    gradient, which step edges have; relative to the blurred green plus a tenth of its mean, so that slow
    shading falls out and a gain of the whole image leaves the result as it is. The largest over the scales,
    in whichever order. A grey image is its own green, and what is not visible is black.

    Raises:
        ImageError: an image that cannot be used; no scale, or one that is no length.

    Example:
        >>> import numpy as np
        >>> from enhance import vesselness
        >>> image = np.full((96, 96, 3), 180, np.uint8)
        >>> image[:, 46:50] = 120
        >>> strength = vesselness(image)
        >>> int(strength[48].argmax()) in range(46, 50), float(strength[48, 10].round(6))
        (True, 0.0)
    """
    if len(sigmas) == 0:
        raise ImageError("expected at least one sigma, got none")
    if wrong := [sigma for sigma in sigmas if not LEAST_SIGMA <= sigma < np.inf]:
        raise ImageError(f"expected sigmas of at least {LEAST_SIGMA} pixels, got {wrong[0]}")
    # Only here: its kernel loads the compiler.
    from enhance.ridge_strength import strengthen

    plane = unit(green(seen(image)))
    kernels = [np.stack([gaussian_kernel(sigma, order) for order in range(3)]) for sigma in sigmas]
    margin = max(kernel.shape[1] // 2 for kernel in kernels) + 1
    padded = np.asarray(cv2.copyMakeBorder(plane, *(margin,) * 4, cv2.BORDER_REFLECT), np.float32)
    strength = np.zeros_like(plane)
    for sigma, kernel in zip(sigmas, kernels, strict=True):
        floor = SHADOW * _blurred_mean(plane, kernel[0])
        strengthen(padded, margin, _halves(kernel), float(sigma), floor, strength)
    return strength


def field_of_view(image: AnyImage) -> BoolImage:
    """What the endoscope sees, (H, W): True but for a dark surround; all where there is none, or where the
    image is too dark to tell. See `enhance.find_field`.

    Raises:
        ImageError: an image that cannot be used.

    Example:
        >>> import numpy as np
        >>> from enhance import field_of_view
        >>> image = np.zeros((64, 64, 3), np.uint8)
        >>> image[8:56, 8:56] = 150
        >>> bool(field_of_view(image)[32, 32]), bool(field_of_view(image)[2, 2])
        (True, False)
    """
    return _field(read_picture(image).seen)


def vessel_mask(
    image: AnyImage, *, tissue_mask: AnyImage | None = None, share: float = SHARE, scale: float = 1.0
) -> BoolImage:
    """The fixed mask of an original, (H, W): the strongest ridges, `share` of the tissue or fewer.

    Meant for comparing methods on the same pixels, not for finding vessels: it also takes other dark lines.

    Args:
        tissue_mask: (H, W), non-zero = keep; None: the field of view. 12 pixels along its edge, the
            image's and that of what is not visible, and 8 around highlights, are left out, and so are specks
            of fewer than 40 pixels.
        share: of the tissue without margin, in (0, 1].
        scale: of all these lengths and of the vessels' widths, as of `line_scale`.

    Raises:
        ImageError: an image that cannot be used, a mask of another size or type, or no such share.

    Example:
        >>> import numpy as np
        >>> from enhance import vessel_mask
        >>> image = np.full((96, 96, 3), 180, np.uint8)
        >>> image[:, 46:50] = 120
        >>> columns = np.flatnonzero(vessel_mask(image).any(axis=0)).tolist()
        >>> 40 < columns[0] <= columns[-1] < 56
        True
    """
    if not 0 < share <= 1:
        raise ImageError(f"expected a share above 0, up to 1, got {share}")
    picture = read_picture(image)
    tissue = read_mask(tissue_mask, picture)
    if tissue_mask is None:
        tissue &= _field(picture.seen)
    strength = vesselness(image, _sigmas(scale))
    inside = _eroded(tissue, scaled(MARGIN, scale, 2)) & _eroded(~glare(image), scaled(GLARE_MARGIN, scale))
    if not inside.any():
        return inside
    threshold = np.quantile(strength[inside], 1 - share)
    return _without_specks(inside & (strength > threshold), scaled(LEAST_AREA, scale**2))


def glare(image: AnyImage) -> BoolImage:
    """Visible specular highlights, (H, W): where all channels are at 235 of 255 or above."""
    return np.asarray(unit(np.minimum.reduce(channels(seen(image)))) >= np.float32(GLARE))


def creases(image: AnyImage, *, scale: float = 1.0) -> BoolImage:
    """Narrow places of less than half of the green around them, (H, W): gaps between folds and the shadows of
    tools, in which `vessel_mask` finds dark lines.

    Of vessels, 95 % of those that the mask finds in the retina, on the abdominal wall and at the placenta
    keep 64 % of the green around them or more.

    Raises:
        ImageError: an image that cannot be used.

    Example:
        >>> import numpy as np
        >>> from enhance.ridges import creases
        >>> image = np.full((96, 96, 3), 180, np.uint8)
        >>> image[:, 20:24], image[:, 60:64] = 120, 30
        >>> np.flatnonzero(creases(image)[48]).tolist()
        [60, 61, 62, 63]
    """
    smooth = cv2.GaussianBlur(unit(green(seen(image))), (0, 0), _sigmas(scale)[0])
    around = cv2.morphologyEx(smooth, cv2.MORPH_CLOSE, disc(scaled(CREASE_RADIUS, scale, 2)))
    return np.asarray(smooth < CREASE * around)


def _field(picture: Picture) -> BoolImage:
    # Only here: its kernels load the compiler, which no other ridge needs.
    from enhance.shown import found_in

    return found_in(picture).mask()


def _sigmas(scale: float) -> tuple[float, ...]:
    return tuple(sigma if scale == 1 else max(FINEST, sigma * scale) for sigma in SIGMAS)


def _halves(kernels: NDArray[np.float64]) -> NDArray[np.float64]:
    """From the middle on, with a 0 at the end where their reach would be odd."""
    reach = kernels.shape[1] // 2
    return np.pad(kernels[:, reach:], ((0, 0), (0, reach % 2)))


def _blurred_mean(plane: Float32Image, kernel: NDArray[np.float64]) -> float:
    """Of the blurred plane, which is not made for it: each pixel counts as often as it is reflected."""
    reach, shares = len(kernel) // 2, list[NDArray[np.float64]]()
    for size in plane.shape:
        place = np.pad(np.arange(size), reach, mode="symmetric")
        shares.append(np.asarray(np.bincount(place, np.convolve(np.ones(size), kernel)), np.float64))
    return float(shares[0] @ np.einsum("yx,x->y", plane, shares[1])) / plane.size


def gaussian_kernel(sigma: float, order: int) -> NDArray[np.float64]:
    """Sampled Gaussian derivative, flipped for correlation, exact on polynomials up to its order."""
    reach = int(np.ceil(4 * sigma))
    x = np.arange(-reach, reach + 1, dtype=np.float64)
    weight = np.exp(-(x**2) / (2 * sigma**2))
    weight /= weight.sum()
    if order == 0:
        return weight
    if order == 1:
        return np.asarray(x * weight / np.sum(x**2 * weight))
    second = (x**2 - np.sum(x**2 * weight)) * weight
    return np.asarray(2 * second / np.sum(x**2 * second))


def _eroded(mask: BoolImage, radius: int) -> BoolImage:
    # What lies outside the picture is not kept: its edge is one, too.
    kept = cv2.erode(mask.astype(np.uint8), disc(radius), borderType=cv2.BORDER_CONSTANT, borderValue=0)
    return np.asarray(kept) > 0


def _without_specks(mask: BoolImage, least: int) -> BoolImage:
    _, labels, facts, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    large = facts[:, cv2.CC_STAT_AREA] >= least
    large[0] = False
    return np.asarray(large[labels])
