"""The edge: which images are accepted, and how the result gets the input's type back."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

AnyImage = NDArray[Any]
Float32Image = NDArray[np.float32]
BoolImage = NDArray[np.bool_]
# Types are compared as these: to look up `np.uint8`, and to make a dtype of it each time, takes longer.
BYTES: Final = np.dtype(np.uint8)
WHOLE: Final = BYTES, np.dtype(np.uint16)


class ImageError(ValueError):
    """An image, its mask or its statistics cannot be used: what was expected and what came.

    Example:
        >>> import numpy as np
        >>> from enhance import ImageError, enhance
        >>> try:
        ...     enhance(np.zeros((8, 8, 5), np.uint8))
        ... except ImageError as error:
        ...     print(error)
        expected an image of shape (H, W), (H, W, 3) or (H, W, 4), got (8, 8, 5)
    """


@dataclass(frozen=True, eq=False)
class Picture:
    """An accepted image, colours apart from alpha."""

    pixels: AnyImage
    """(H, W) grey or (H, W, 3), as they came."""
    alpha: AnyImage | None
    """(H, W) as it came, or None."""

    @cached_property
    def colors(self) -> Float32Image:
        """The pixels in [0, 1], C-contiguous."""
        scaled = self.pixels.astype(np.float32, order="C")
        if (full := full_scale(self.dtype)) > 1:
            scaled /= np.float32(full)
        return scaled

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the input, and of the result."""
        return self.pixels.dtype

    @property
    def visible(self) -> BoolImage:
        """(H, W), False where alpha is 0."""
        if self.alpha is None:
            return np.ones(self.pixels.shape[:2], dtype=bool)
        return np.asarray(self.alpha > 0)

    @property
    def seen(self) -> Picture:
        """Without alpha and black where nothing is visible: what is stored there does not reach pixels beside
        it."""
        return self if self.alpha is None else Picture(self.pixels * self.visible[..., None], None)

    @property
    def filled(self) -> Picture:
        """With the nearest visible colours where alpha is 0; itself where all is visible, or nothing."""
        if self.alpha is None or not (hidden := ~self.visible).any() or hidden.all():
            return self
        _, nearest = cv2.distanceTransformWithLabels(
            hidden.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
        )
        # Black beyond the 65 534 px that OpenCV measures, where it says 0.
        colors = np.zeros((int(nearest.max()) + 1, 3), self.dtype)
        colors[nearest[~hidden]] = self.pixels[~hidden]
        return Picture(colors[nearest], self.alpha)

    def with_colors(self, colors: Float32Image) -> AnyImage:
        """`colors` (shape of self.colors) as an image of the input's type, alpha untouched."""
        full = full_scale(self.dtype)
        clipped = np.clip(colors, 0.0, 1.0)
        pixels = (np.rint(clipped * full) if full > 1 else clipped).astype(self.dtype)
        return pixels if self.alpha is None else np.dstack((pixels, self.alpha))


@lru_cache
def full_scale(dtype: np.dtype[Any]) -> int:
    """The value that means 1.0: 255, 65535, or 1 for floats."""
    return int(np.iinfo(dtype).max) if dtype.kind == "u" else 1


def read_picture(image: AnyImage) -> Picture:
    """Check an image and bring it to float32 in [0, 1]; the input is not modified.

    Args:
        image: (H, W) grey, (H, W, 3) or (H, W, 4) with alpha last; uint8, uint16 (full scale 65535) or
            float in [0, 1], of either byte order. The order of the three colours does not matter: the
            maths is symmetric.

    Raises:
        ImageError: anything else, NaN, and masked arrays.
    """
    if type(image) is not np.ndarray or image.dtype != BYTES:
        image = _plain(image, "an image")
    check_shape(image)
    _check_values(image)
    alpha = image[..., 3] if image.ndim == 3 and image.shape[2] == 4 else None
    colors = image if alpha is None else image[..., :3]
    return Picture(pixels=colors, alpha=alpha)


def read_mask(mask: AnyImage | None, picture: Picture, name: str = "a tissue_mask") -> BoolImage:
    """Pixels that are measured: visible and, where there is a mask, kept by it.

    Args:
        mask: (H, W) bool or integers, non-zero = keep; None keeps all.
        name: what messages call it.

    Raises:
        ImageError: another shape or type, and masked arrays.
    """
    if mask is None:
        return picture.visible
    mask = _plain(mask, name)
    expected = picture.pixels.shape[:2]
    if mask.shape != expected or mask.dtype.kind not in "bui":
        raise ImageError(
            f"expected {name} of shape {expected}, bool or integers, got {mask.shape} {mask.dtype}"
        )
    return np.asarray(picture.visible & (mask != 0))


def _plain(array: AnyImage, name: str) -> AnyImage:
    """In the byte order of this machine, as the kernels and OpenCV read no other."""
    if isinstance(array, np.ma.MaskedArray):
        raise ImageError(
            f"expected {name} without a mask of its own, got a masked array; "
            "pass its .data, and what to leave out as tissue_mask"
        )
    got = type(array).__name__
    try:
        array = np.asarray(array)
    except (RuntimeError, TypeError, ValueError) as error:
        # Of other libraries' tensors, and of ragged lists.
        raise ImageError(f"expected {name} that numpy can read, got {got}: {error}") from error
    if array.dtype.kind in "OUSV":
        raise ImageError(f"expected {name} as an array of numbers, got {got} of {array.dtype}")
    return array if array.dtype.isnative else array.astype(array.dtype.newbyteorder("="))


def check_shape(image: AnyImage) -> None:
    """Raises ImageError: it is no image by its axes, or one without pixels."""
    grey, color = image.ndim == 2, image.ndim == 3 and image.shape[-1] in (3, 4)
    if not (grey or color):
        raise ImageError(f"expected an image of shape (H, W), (H, W, 3) or (H, W, 4), got {image.shape}")
    if image.size == 0:
        raise ImageError(f"expected an image with at least one pixel, got shape {image.shape}")


def _check_values(image: AnyImage) -> None:
    if image.dtype in WHOLE:
        return
    if image.dtype.kind != "f":
        raise ImageError(f"expected uint8, uint16 or float in [0, 1], got {image.dtype}")
    low, high = image.min(), image.max()
    if np.isnan(low):
        missing = np.isnan(image)
        count, first = np.count_nonzero(missing), tuple(np.argwhere(missing)[0].tolist())
        channel = f", channel {first[2]}" if image.ndim == 3 else ""
        raise ImageError(
            f"expected an image without NaN, got {count} of {image.size} values that are, the first at row "
            f"{first[0]}, column {first[1]}{channel} (from 0); replace NaN before enhancing"
        )
    if low < 0.0 or high > 1.0:
        # With all digits of the image's own precision: rounding may be what is beyond.
        got = " to ".join(str(end).removesuffix(".0") for end in (low, high))
        raise ImageError(f"expected float values in [0, 1], got {got}; scale or clip them first")
