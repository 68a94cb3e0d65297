"""How near a picture is to its reference: PSNR both ways, SSIM, depth error. All sums in float64."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.clip import BoolImage

AnyFloat = NDArray[np.floating[Any]]

OPAQUE = 0.9
"""Alpha above which tissue counts as reconstructed."""
_WINDOW, _SIGMA = 11, 1.5
_PIXELS = 1 << 15
_C1, _C2 = 0.01**2, 0.03**2


def psnr(image: AnyFloat, reference: AnyFloat, mask: BoolImage) -> float:
    """PSNR in dB as usually published: both images times the mask, mean over all pixels.

    Images (H, W, 3) or (H, W) in [0, 1]; mask (H, W), True = counted. Pixels outside count as
    free of error, so the value is higher than `psnr_masked` by -10 log10(share of the mask).
    Rounding to 8 bits, as in published figures, is left to the caller. Infinite for equal images, NaN
    for an empty mask.

    Raises:
        ValueError: shapes that do not agree, or images of whole numbers, whose scale is not [0, 1].

    Example:
        >>> import numpy as np
        >>> from renderer import psnr
        >>> reference, mask = np.full((16, 16, 3), 0.5), np.zeros((16, 16), bool)
        >>> mask[:4] = True
        >>> round(psnr(reference + 0.1, reference, mask), 2)  # 20 dB of a quarter of the pixels
        26.02
    """
    error = _squared_error(image, reference, mask)
    return _decibel(error / image.size) if mask.any() else float("nan")


def psnr_masked(image: AnyFloat, reference: AnyFloat, mask: BoolImage) -> float:
    """PSNR in dB over the pixels of the mask alone; NaN for an empty mask. Otherwise as `psnr`.

    Example:
        >>> import numpy as np
        >>> from renderer import psnr_masked
        >>> reference, mask = np.full((16, 16, 3), 0.5), np.zeros((16, 16), bool)
        >>> mask[:4] = True
        >>> round(psnr_masked(reference + 0.1, reference, mask), 2)
        20.0
    """
    error = _squared_error(image, reference, mask)
    counted = np.count_nonzero(mask) * (image.size // max(mask.size, 1))
    return _decibel(error / counted) if counted else float("nan")


def ssim(image: AnyFloat, reference: AnyFloat, mask: BoolImage) -> float:
    """Mean structural similarity, at most 1 (Wang et al. 2004, Eq 13), as usually published.

    Both images times the mask, 11x11 Gaussian window of sigma 1.5, zeros beyond the border,
    mean over all pixels and channels; NaN for an empty mask. Arguments and errors as for `psnr`.

    Example:
        >>> import numpy as np
        >>> from renderer import ssim
        >>> reference, mask = np.full((16, 16, 3), 0.5), np.zeros((16, 16), bool)
        >>> mask[:4] = True
        >>> round(ssim(reference, reference, mask), 6)
        1.0
    """
    total, _ = _similarities(image, reference, mask)
    return total / image.size if np.any(mask) else float("nan")


def ssim_masked(image: AnyFloat, reference: AnyFloat, mask: BoolImage) -> float:
    """The mean of `ssim` over the pixels of the mask alone, whose windows see zeros beyond it; NaN for an
    empty mask.

    Example:
        >>> import numpy as np
        >>> from renderer.metrics import ssim, ssim_masked
        >>> reference, mask = np.random.default_rng(0).random((16, 16)), np.zeros((16, 16), bool)
        >>> mask[:4] = True
        >>> ssim_masked(reference * 0.5, reference, mask) < ssim(reference * 0.5, reference, mask)
        True
    """
    _, counted = _similarities(image, reference, mask)
    pixels = int(np.count_nonzero(mask))
    return counted * mask.size / (image.size * pixels) if pixels else float("nan")


def _similarities(image: AnyFloat, reference: AnyFloat, mask: BoolImage) -> tuple[float, float]:
    """Of both images times the mask: the sums over all pixels and channels, and over those of the mask."""
    total = counted = 0.0
    for x, y, own, kept in _strips(image, reference, mask, _WINDOW // 2):
        similarity = _similarity(x, y)[own]
        total += float(similarity.sum())
        counted += float(similarity.sum(axis=2)[kept].sum())
    return total, counted


def _strips(
    image: AnyFloat, reference: AnyFloat, mask: BoolImage, beside: int = 0
) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64], slice, BoolImage]]:
    """Both `masked`, a few rows at a time, so that what is computed on the way stays in the cache: with as
    many rows beside them as that needs, which are their own, and the mask of those."""
    _check(image, reference, mask)
    each = max(_PIXELS // max(mask.shape[1], 1), _WINDOW)
    for top in range(0, max(len(mask), 1), each):
        first = max(top - beside, 0)
        rows = slice(first, top + each + beside)
        x, y = masked(image[rows], reference[rows], mask[rows])
        yield x, y, slice(top - first, top - first + each), mask[top : top + each]


def _similarity(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """(h, W, channels), of images of this shape."""
    mean_x, mean_y = _window(x), _window(y)
    variance_x = _window(x * x) - mean_x**2
    variance_y = _window(y * y) - mean_y**2
    covariance = _window(x * y) - mean_x * mean_y
    similarity = (2 * mean_x * mean_y + _C1) * (2 * covariance + _C2)
    similarity /= (mean_x**2 + mean_y**2 + _C1) * (variance_x + variance_y + _C2)
    return similarity


def depth_rmse(depth: AnyFloat, reference: AnyFloat, mask: BoolImage) -> float:
    """Root mean square difference of two depth maps (H, W), in their unit (mm).

    Over the pixels of the mask where both are measured (> 0 and finite); NaN when there is none.

    Raises:
        ValueError: shapes that do not agree.

    Example:
        >>> import numpy as np
        >>> from renderer import depth_rmse
        >>> depth_rmse(np.array([[52.0, 0.0]]), np.array([[50.0, 50.0]]), np.array([[True, True]]))
        2.0
    """
    drawn, true = _depths(depth, reference, mask)
    return float(np.sqrt(np.mean((drawn - true) ** 2))) if len(true) else float("nan")


def depth_abs_rel(depth: AnyFloat, reference: AnyFloat, mask: BoolImage) -> float:
    """Mean of |depth - reference| / reference, without unit (Eigen et al., NeurIPS 2014). Otherwise as
    `depth_rmse`."""
    drawn, true = _depths(depth, reference, mask)
    return float(np.mean(np.abs(drawn - true) / true)) if len(true) else float("nan")


def depth_coverage(depth: AnyFloat, reference: AnyFloat, mask: BoolImage) -> float:
    """Share of the measured reference pixels of the mask, 0 to 1, where there is a depth to compare: the
    others are in no depth error. NaN when none is measured."""
    drawn, _ = _depths(depth, reference, mask)
    measured = np.count_nonzero(mask & _is_measured(reference))
    return len(drawn) / measured if measured else float("nan")


def coverage(alpha: AnyFloat, tissue: BoolImage) -> float:
    """Share of the tissue's pixels (H, W) where the model is at least 90 % opaque, 0 to 1; NaN without any.

    Example:
        >>> import numpy as np
        >>> from renderer.metrics import coverage
        >>> coverage(np.array([[1.0, 0.5, 0.0]]), np.array([[True, True, False]]))
        0.5
    """
    return float(np.mean(alpha[tissue] >= OPAQUE)) if tissue.any() else float("nan")


def masked(
    image: AnyFloat, reference: AnyFloat, mask: BoolImage
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Both pictures as (H, W, channels) float64, zero outside the mask whatever they hold there.

    Raises:
        ValueError: shapes that do not agree, or whole numbers.
    """
    _check(image, reference, mask)
    if whole := next((one.dtype for one in (image, reference) if one.dtype.kind != "f"), None):
        raise ValueError(f"expected images of floats in [0, 1], got {whole}: divide uint8 by 255")
    x, y = (picture.reshape(*mask.shape, -1).astype(np.float64) for picture in (image, reference))
    x[~mask] = y[~mask] = 0.0
    return x, y


def _depths(
    depth: AnyFloat, reference: AnyFloat, mask: BoolImage
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Both depths of the pixels of the mask where both are measured."""
    _check(depth, reference, mask)
    both = mask & _is_measured(depth) & _is_measured(reference)
    return depth[both].astype(np.float64), reference[both].astype(np.float64)


def _is_measured(depth: AnyFloat) -> BoolImage:
    return np.asarray((depth > 0) & (depth < np.inf))


def _check(image: AnyFloat, reference: AnyFloat, mask: BoolImage) -> None:
    """Raises TypeError: not three arrays; ValueError: arrays that do not fit each other."""
    if not all(isinstance(one, np.ndarray) for one in (image, reference, mask)):
        kinds = ", ".join(type(one).__name__ for one in (image, reference, mask))
        raise TypeError(f"expected two images and a mask as numpy arrays, got {kinds}")
    if image.shape != reference.shape or image.shape[:2] != mask.shape or mask.dtype != np.bool_:
        shapes = f"{image.shape}, {reference.shape} and {mask.dtype} {mask.shape}"
        raise ValueError(f"expected two images of one shape and a bool mask of their size, got {shapes}")


def _squared_error(image: AnyFloat, reference: AnyFloat, mask: BoolImage) -> float:
    """Its sum."""
    return sum(float(((x - y) ** 2).sum()) for x, y, *_ in _strips(image, reference, mask))


def _decibel(mean_squared_error: float) -> float:
    return float("inf") if mean_squared_error == 0 else float(-10 * np.log10(mean_squared_error))


def _window(picture: NDArray[np.float64]) -> NDArray[np.float64]:
    kernel = cv2.getGaussianKernel(_WINDOW, _SIGMA, cv2.CV_64F)
    means = cv2.sepFilter2D(picture, cv2.CV_64F, kernel, kernel, borderType=cv2.BORDER_CONSTANT)
    return np.asarray(means, dtype=np.float64).reshape(picture.shape)
