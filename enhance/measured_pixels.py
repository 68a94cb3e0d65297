"""Pixels of an image as measures read them: those whose alpha is 0 count in none."""

from __future__ import annotations

from numpy.typing import NDArray

from enhance.brightness import Number
from enhance.image import AnyImage, BoolImage, Float32Image, ImageError, Picture, read_mask, read_picture


def seen(image: AnyImage) -> AnyImage:
    """(H, W) or (H, W, 3) of the image's own type, black where nothing is visible. Raises ImageError."""
    return read_picture(image).seen.pixels


def kept(image: AnyImage, mask: BoolImage | None = None) -> BoolImage:
    """(H, W), True where something is visible and the mask, if any, keeps it.

    Raises:
        ImageError: an image that cannot be used, or a mask of another size or type.
    """
    return read_mask(mask, read_picture(image), "a mask")


def check_sizes(image: AnyImage, original: AnyImage) -> None:
    """Raises ImageError where they differ."""
    if image.shape != original.shape:
        raise ImageError(f"expected image and original of one size, got {image.shape} and {original.shape}")


def unit(pixels: AnyImage) -> Float32Image:
    """Some of what is `seen`, of any shape, in [0, 1]: only what is needed is scaled."""
    return Picture(pixels, None).colors


def channels(pixels: AnyImage) -> list[AnyImage]:
    """Each (H, W): three, or that of a grey image."""
    return [pixels] if pixels.ndim == 2 else [pixels[..., channel] for channel in range(3)]


def green(colors: NDArray[Number]) -> NDArray[Number]:
    """(H, W) of what is `seen`: a grey image is its own."""
    return colors if colors.ndim == 2 else colors[..., 1]
