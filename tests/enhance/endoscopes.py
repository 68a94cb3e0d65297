"""What endoscopes give: tissue in a field of view, round or not, with whatever lies around it."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance.field import FieldOfView
from enhance.field_search import find_field
from enhance.image import BoolImage
from tests.enhance.pictures import ByteImage, vessels

OUTLINES = ("circle", "cropped circle", "wide circle", "beside the middle", "octagon", "D")
APART = (
    "two circles",
    "two cut circles",
    "two ellipses",
    "two rectangles",
    "circle and inset",
    "four rectangles",
)
TOUCHING = ("two that touch", "two that overlap", "a large and a small one")
SEVERAL = {
    "three in a row": ((-0.43, 0.0, 0.22), (0.0, 0.0, 0.21), (0.43, 0.0, 0.22)),
    "three in a triangle": ((-0.223, -0.19, 0.225), (0.223, -0.19, 0.22), (0.0, 0.197, 0.222)),
    "two by two": (
        (-0.226, -0.226, 0.225),
        (0.226, -0.226, 0.224),
        (-0.226, 0.226, 0.222),
        (0.226, 0.226, 0.225),
    ),
}
"""Touching, too: middles, x and y, about that of the picture, and radii, by its height."""

RIM = 8
"""Pixels within the true outline that may be left out: two are on purpose."""


def outline(name: str, height: int = 240, width: int = 320) -> BoolImage:
    """(H, W), True = field of view."""
    y, x = np.mgrid[:height, :width] + 0.5
    if name == "octagon":
        across, down = np.abs(x - width / 2), np.abs(y - height / 2)
        cut = 0.72 * (0.45 * width + 0.45 * height)
        return np.asarray((across < 0.45 * width) & (down < 0.45 * height) & (across + down < cut))
    if name in TOUCHING:
        # Middles across, and radii, by the width.
        at, other, radius, small = {
            "two that touch": (0.28, 0.7, 0.22, 0.21),
            "two that overlap": (0.3, 0.7, 0.23, 0.23),
            "a large and a small one": (0.32, 0.7, 0.27, 0.14),
        }[name]
        pair = ((np.hypot(x - a * width, y - height / 2), r) for a, r in ((at, radius), (other, small)))
        return np.asarray(np.any([away < r * width for away, r in pair], axis=0))
    if name in SEVERAL:
        across, down = (x - width / 2) / height, (y - height / 2) / height
        circles = [np.hypot(across - at, down - row) < radius for at, row, radius in SEVERAL[name]]
        return np.asarray(np.any(circles, axis=0))
    if name in APART:
        return _apart(name, x / width, y / height, width / height)
    if name == "D":
        return np.asarray((np.hypot(x - width / 2, y - height / 2) < 0.45 * height) & (x > 0.35 * width))
    at, radius = {
        "circle": ((0.5, 0.5), 0.45),
        "cropped circle": ((0.5, 0.5), 0.56),
        "wide circle": ((0.5, 0.5), 0.66),
        "beside the middle": ((0.62, 0.45), 0.48),
    }[name]
    return np.asarray(np.hypot(x - at[0] * width, y - at[1] * height) < radius * height)


def _apart(name: str, x: NDArray[np.float64], y: NDArray[np.float64], aspect: float) -> BoolImage:
    """x, y: shares of width and height."""
    left, right = (np.hypot((x - at) * aspect, y - 0.5) for at in (0.25, 0.75))
    if name == "two circles":
        return np.asarray((left < 0.31) | (right < 0.29))
    if name == "two cut circles":
        return np.asarray(((left < 0.39) & (x < 0.48)) | ((right < 0.39) & (x > 0.52)))
    if name == "circle and inset":
        return np.asarray(
            (np.hypot((x - 0.35) * aspect, y - 0.5) < 0.4) | ((abs(x - 0.82) < 0.14) & (y > 0.6))
        )
    if name == "two ellipses":
        return np.asarray(
            np.minimum(np.hypot(x - 0.25, (y - 0.5) / 2), np.hypot(x - 0.75, (y - 0.5) / 2)) < 0.21
        )
    across = np.minimum(abs(x - 0.25), abs(x - 0.75))
    if name == "two rectangles":
        return np.asarray((across < 0.18) & (abs(y - 0.5) < 0.4))
    return np.asarray((across < 0.18) & (np.minimum(abs(y - 0.26), abs(y - 0.76)) < 0.19))


def seen_in(
    field: BoolImage, *, black: float = 3.0, noise: float = 1.0, seed: int = 0, dim: float = 0.0
) -> ByteImage:
    """(H, W, 3): tissue within the field, a dark surround with noise beyond it, the rim as soft as lenses
    make it. dim: how much darker tissue is at the far end of the picture."""
    height, width = field.shape
    tissue = vessels(height, width, seed).astype(np.float64)
    tissue[tissue.max(axis=2) < 30] = (90, 50, 45)
    tissue *= (1 - dim * np.arange(width) / width)[:, None]
    soft = cv2.GaussianBlur(field.astype(np.float64), (0, 0), 0.8)[..., None]
    rng = np.random.default_rng(seed)
    image = soft * tissue + (1 - soft) * black + rng.normal(0, noise, tissue.shape)
    return np.rint(np.clip(image, 0, 255)).astype(np.uint8)


def labelled(image: ByteImage) -> ByteImage:
    """With a line of text and a bright box in its upper left corner."""
    marked = image.copy()
    cv2.putText(marked, "PATIENT 07", (3, 12), cv2.FONT_HERSHEY_SIMPLEX, 0.35, (230, 230, 230), 1)
    marked[24:40, 4:16] = 255, 200, 0
    return marked


def agreement(one: NDArray[np.bool_], other: NDArray[np.bool_]) -> float:
    """Intersection over union."""
    return float((one & other).sum() / max((one | other).sum(), 1))


def assert_found(mask: BoolImage, field: BoolImage, rim: int = RIM) -> None:
    """Nothing of the surround, and all of the field but its rim."""
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * rim + 1, 2 * rim + 1))
    inner = cv2.erode(field.astype(np.uint8), kernel) > 0
    assert not mask[~field].any()
    assert mask[inner].all()


def found(image: NDArray[np.generic]) -> FieldOfView:
    field = find_field(image)
    assert field is not None
    return field
