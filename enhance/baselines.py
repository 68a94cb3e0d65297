"""Other methods to compare with, each one function from (H, W, 3) uint8 RGB to a new array of the same.

"Wang" of the paper's Table 3 is taken to be Wang 2020. "Tao" is not identified: `msrcr`, `aindane` and
`aindane_green` stand in for it, as methods that fit its description, and are never called by that name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance.brightness import brighten, level, value, value_histogram, z_from_level
from enhance.detail import FLOOR
from enhance.image import Float32Image, ImageError
from enhance.saturation import Saturation, recolor, saturation, stretch

ByteImage = NDArray[np.uint8]
Method = Callable[[ByteImage], ByteImage]

LUMA: Final = np.array([0.299, 0.587, 0.114], dtype=np.float32)
MOST_GAIN: Final = 4.0
"""Limit on AINDANE's colour gain: without it, dark pixels turn into colour spots."""


def clahe(image: ByteImage) -> ByteImage:
    """CLAHE on L of Lab, clip limit 2, 8x8 tiles (Zuiderveld, Graphics Gems IV, 1994).

    Raises:
        ImageError: anything but (H, W, 3) uint8.

    Example:
        >>> import numpy as np
        >>> from enhance import clahe
        >>> image = np.random.default_rng(0).integers(0, 200, (64, 64, 3), dtype=np.uint8)
        >>> clahe(image).shape
        (64, 64, 3)
    """
    _require_bytes(image)
    lab = cv2.cvtColor(image, cv2.COLOR_RGB2LAB)
    equalize = cv2.createCLAHE(clipLimit=2.0, tileGridSize=(8, 8))
    lab[..., 0] = equalize.apply(np.ascontiguousarray(lab[..., 0]))
    return np.asarray(cv2.cvtColor(lab, cv2.COLOR_LAB2RGB), dtype=np.uint8)


def unsharp(image: ByteImage) -> ByteImage:
    """Unsharp mask: the difference to a Gaussian of sigma 3 px is added once more.

    Raises:
        ImageError: anything but (H, W, 3) uint8.

    Example:
        >>> import numpy as np
        >>> from enhance import unsharp
        >>> image = np.random.default_rng(0).integers(0, 200, (64, 64, 3), dtype=np.uint8)
        >>> unsharp(image).shape
        (64, 64, 3)
    """
    colors = _unit(image)
    return _bytes(2 * colors - cv2.GaussianBlur(colors, (0, 0), 3.0))


def msrcr(image: ByteImage) -> ByteImage:
    """Multi-scale retinex with colour restoration (Jobson, Rahman and Woodell, IEEE TIP 6(7), 1997).

    Scales 15, 80 and 250 px, alpha 125. The published gain, offset and beta are affine and cancel in the
    stretch of the 1st to the 99th percentile of the image, which ends it, as is usual.

    Raises:
        ImageError: anything but (H, W, 3) uint8.

    Example:
        >>> import numpy as np
        >>> from enhance import msrcr
        >>> image = np.random.default_rng(0).integers(0, 200, (64, 64, 3), dtype=np.uint8)
        >>> msrcr(image).shape
        (64, 64, 3)
    """
    _require_bytes(image)
    colors = image.astype(np.float32) + 1
    retinex = np.mean([np.log(colors) - np.log(_blurred(colors, sigma)) for sigma in (15, 80, 250)], axis=0)
    restored = retinex * np.log(125 * colors / colors.sum(axis=2, keepdims=True))
    low, high = np.percentile(restored, (1, 99))
    return _bytes((restored - low) / max(high - low, 1e-6))


def aindane(image: ByteImage) -> ByteImage:
    """AINDANE on luma (Tao and Asari, Journal of Electronic Imaging 14(4) 043006, 2005); gain at most 4.

    Raises:
        ImageError: anything but (H, W, 3) uint8.

    Example:
        >>> import numpy as np
        >>> from enhance import aindane
        >>> image = np.random.default_rng(0).integers(0, 200, (64, 64, 3), dtype=np.uint8)
        >>> aindane(image).shape
        (64, 64, 3)
    """
    colors = _unit(image)
    return _aindane(colors, np.asarray(colors @ LUMA, dtype=np.float32))


def aindane_green(image: ByteImage) -> ByteImage:
    """AINDANE with green instead of luma. VesselSplat's variant: a stand-in for a method that works on green.

    Raises:
        ImageError: anything but (H, W, 3) uint8.

    Example:
        >>> import numpy as np
        >>> from enhance import aindane_green
        >>> image = np.random.default_rng(0).integers(0, 200, (64, 64, 3), dtype=np.uint8)
        >>> aindane_green(image).shape
        (64, 64, 3)
    """
    colors = _unit(image)
    return _aindane(colors, np.ascontiguousarray(colors[..., 1]))


def wang2020(image: ByteImage) -> ByteImage:
    """Nonlinear contrast stretching of green, then of saturation (Wang Q. et al., Opto-Electronic
    Engineering 47(1) 190268, 2020).

    Red and blue follow by the change of green. The order of clipping is inferred.

    Raises:
        ImageError: anything but (H, W, 3) uint8.

    Example:
        >>> import numpy as np
        >>> from enhance import wang2020
        >>> image = np.random.default_rng(0).integers(0, 200, (64, 64, 3), dtype=np.uint8)
        >>> wang2020(image).shape
        (64, 64, 3)
    """
    colors = _unit(image)
    green = colors[..., 1]
    change = stretch(Saturation(chroma=green, white=1 - green), float(green.mean()), 1.0) - green
    stretched: Float32Image = np.clip(colors + change[..., None], 0, 1)
    bright = value(stretched)
    parts = saturation(stretched, bright)
    colored = stretch(parts, float(parts.chroma.mean()), 1.0)
    return _bytes(recolor(stretched, bright, parts, bright, colored))


def jiang2019(image: ByteImage) -> ByteImage:
    """Guided-filter base and detail of each channel, toned and added again (Jiang et al., Opto-Electronic
    Engineering 46(1) 180167, 2019).

    All constants are inferred: detail times 1.75, base of green and blue through
    1.245 / (1 + (0.545 / x)^2.35), base of red times 0.9, radius 16 px, eps 0.01. The published detail gain
    follows the signal to noise ratio.

    Raises:
        ImageError: anything but (H, W, 3) uint8.

    Example:
        >>> import numpy as np
        >>> from enhance import jiang2019
        >>> image = np.random.default_rng(0).integers(0, 200, (64, 64, 3), dtype=np.uint8)
        >>> jiang2019(image).shape
        (64, 64, 3)
    """
    colors = _unit(image)
    planes = [np.ascontiguousarray(colors[..., index]) for index in range(3)]
    bases = [_base(plane) for plane in planes]
    details = [plane - base for plane, base in zip(planes, bases, strict=True)]
    toned = [0.9 * bases[0], *(_jiang_tone(base) for base in bases[1:])]
    return _bytes(
        np.stack([base + 1.75 * detail for base, detail in zip(toned, details, strict=True)], axis=2)
    )


BASELINES: Final[Mapping[str, Method]] = {
    "clahe": clahe,
    "unsharp": unsharp,
    "msrcr": msrcr,
    "aindane": aindane,
    "aindane-green": aindane_green,
    "wang2020": wang2020,
    "jiang2019": jiang2019,
}
"""By the names of the command line and of the comparison table."""
TAO_STAND_INS: Final = ("msrcr", "aindane", "aindane-green")


def _aindane(colors: Float32Image, intensity: Float32Image) -> ByteImage:
    """Brightness, contrast against Gaussian surrounds c = 5, 20 and 240, ratio colour restoration."""
    z = z_from_level(level(value_histogram(intensity).cumsum()))
    lifted = brighten(intensity, z)
    p = _aindane_exponent(255 * float(intensity.std()))
    e = np.float32(FLOOR)
    surrounds = [_blurred(intensity, c / np.sqrt(2)) for c in (5, 20, 240)]
    new = np.mean([lifted ** (((around + e) / (intensity + e)) ** p) for around in surrounds], axis=0)
    ratio = np.divide(new, intensity, out=np.zeros_like(intensity), where=intensity > 0)
    return _bytes(colors * np.minimum(ratio, np.float32(MOST_GAIN))[..., None])


def _aindane_exponent(sigma: float) -> float:
    """Twice as steep as Eq 9 of the paper, from 3 down to 1; sigma in grey levels."""
    return min(max((27 - 2 * sigma) / 7, 1.0), 3.0)


def _base(plane: Float32Image) -> Float32Image:
    filtered = cv2.ximgproc.guidedFilter(plane, plane, 16, 0.01)
    return np.asarray(np.clip(filtered, 0, 1), dtype=np.float32)


def _jiang_tone(base: Float32Image) -> Float32Image:
    safe = np.maximum(base, np.float32(1e-6))
    return np.asarray(1.245 / (1 + (0.545 / safe) ** 2.35), dtype=np.float32)


def _blurred(image: Float32Image, sigma: float) -> Float32Image:
    """Gaussian; a wide one at a size that is reduced until sigma is 4 to 8 px, which changes it by little."""
    height, width = image.shape[:2]
    step = 2 ** max(0, int(np.log2(sigma / 4)))
    size = (max(1, width // step), max(1, height // step))
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    blurred = cv2.GaussianBlur(small, (0, 0), sigma / step, borderType=cv2.BORDER_REFLECT)
    return np.asarray(cv2.resize(blurred, (width, height), interpolation=cv2.INTER_LINEAR), dtype=np.float32)


def _require_bytes(image: ByteImage) -> None:
    is_array = isinstance(image, np.ndarray) and not isinstance(image, np.ma.MaskedArray)
    if not is_array or image.dtype != np.uint8 or image.shape[2:] != (3,) or not image.size:
        got = f"{image.shape} {image.dtype}" if is_array else type(image).__name__
        raise ImageError(f"expected an RGB image of shape (H, W, 3) and uint8, got {got}")


def _unit(image: ByteImage) -> Float32Image:
    _require_bytes(image)
    return np.asarray(image / np.float32(255), dtype=np.float32)


def _bytes(colors: NDArray[np.floating]) -> ByteImage:
    return np.asarray(np.rint(255 * np.clip(colors, 0, 1)), dtype=np.uint8)
