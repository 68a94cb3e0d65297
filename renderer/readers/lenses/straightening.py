"""Images of calibrated lenses as lenses without distortion would show them; of two eyes, rectified."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Final, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera, FloatArray
from renderer.clip import BoolImage
from renderer.readers.lenses.calibration import Calibration, LensCalibration

Level = TypeVar("Level", np.uint8, np.uint16, np.float16, np.float32, np.float64)
SAME_SHAPE: Final = 0.005
"""Of the width times the height, by which the shapes of a calibration's images and of a clip's may differ."""
WIDEST: Final = math.radians(75)
"""From the axis: what lies farther out would fill a flat image alone."""
_ZOOMS: Final = np.geomspace(8, 0.05, 500)
_PARTS: Final = cv2.INTER_TAB_SIZE
_ALONG: Final = 33
"""Places on each border that are looked at."""


@dataclass(frozen=True, eq=False)
class Straightening:
    """How an image is straightened."""

    camera: Camera
    """Sees what the straightened image shows; of the size of the frames."""
    places: NDArray[np.int16]
    """(H, W, 2) column and row that each pixel comes from, rounded down."""
    fractions: NDArray[np.uint16]
    """(H, W), the rest in parts of _PARTS, as OpenCV's remap takes it."""

    def image(self, image: NDArray[Level]) -> NDArray[Level]:
        """(H, W) or (H, W, C) of 8 or 16 bits or of floats, between pixels by cubics, which do not leave the
        range of the image."""
        source = image.astype(np.float32) if image.dtype == np.float16 else image
        moved = cv2.remap(source, self.places, self.fractions, cv2.INTER_CUBIC)
        # Beyond both ends of a type of whole numbers OpenCV keeps to them; floats have none.
        kept = np.clip(moved, source.min(), source.max()) if image.dtype.kind == "f" else moved
        return np.asarray(kept, image.dtype)

    def mask(self, kept: BoolImage) -> BoolImage:
        """(H, W), of the nearest pixel; what the lens did not show is not kept."""
        fractions = np.stack([self.fractions % _PARTS, self.fractions // _PARTS], axis=-1)
        x, y = np.moveaxis(self.places + (2 * fractions >= _PARTS), -1, 0)
        height, width = kept.shape
        inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
        return np.asarray(inside & kept[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)])


@dataclass(frozen=True, eq=False)
class StraightEyes:
    """Of a pair, rectified: what both eyes see lies in the same rows, and at infinity in the same columns."""

    left: Straightening
    right: Straightening
    baseline: float
    """mm."""


@dataclass(frozen=True, eq=False)
class Rectified:
    """What the rectified images of a pair are taken with."""

    turns: tuple[FloatArray, FloatArray]
    """(3, 3) from the axes of each eye."""
    camera: Camera
    """Of the left eye, and but for its place of the right one."""
    baseline: float
    """mm."""


@lru_cache(4)
def straightening(lens: LensCalibration, size: tuple[int, int], pixel_aspect: float = 1.0) -> Straightening:
    """Of frames of `size` (width, height), looking the same way; as much of the view as leaves no corner
    empty, and no more than WIDEST. Pixels are `pixel_aspect` times as wide as high, or as those that it was
    made with. Raises ValueError: the calibration is of images of another shape, or its distortion folds."""
    _require_shape(lens.size, size, pixel_aspect)
    scaled = _scaled(lens, size)
    zoom = _zoom(scaled, size)
    camera = Camera(zoom * scaled.fx, zoom * scaled.fy, scaled.cx + 0.5, scaled.cy + 0.5, *size)
    return _straightening(scaled, np.eye(3), camera)


def straight_eyes(calibration: Calibration, size: tuple[int, int], pixel_aspect: float = 1.0) -> StraightEyes:
    """Of pairs of that size, by `rectified`. Raises ValueError as `straightening`, and for one eye."""
    if calibration.right is None:
        raise ValueError("expected a calibration of both eyes, got one of a single lens")
    found = rectified(calibration, size, pixel_aspect)
    left, right = (
        _straightening(_scaled(lens, size), turn, found.camera)
        for lens, turn in zip((calibration.lens, calibration.right.lens), found.turns, strict=True)
    )
    return StraightEyes(left, right, found.baseline)


def rectified(calibration: Calibration, size: tuple[int, int], pixel_aspect: float = 1.0) -> Rectified:
    """Of both eyes, at `size`: by OpenCV's stereoRectify with alpha 0 and no disparity at infinity.

    Raises ValueError: see `straight_eyes`.
    """
    left, right = calibration.lens, calibration.right
    assert right is not None
    full = left.size or size
    for each in (left, right.lens):
        _require_shape(each.size, size, pixel_aspect)
    lenses = left.matrix, left.coefficients, right.lens.matrix, right.lens.coefficients
    moved = right.rotation, right.translation
    flags = cv2.CALIB_ZERO_DISPARITY
    if (right.lens.size or full) != full:
        raise ValueError(f"expected eyes calibrated at one size, got {full} and {right.lens.size}")
    if left.model != right.lens.model:
        raise ValueError(f"expected eyes of one distortion model, got {left.model} and {right.lens.model}")
    try:
        if left.model == "fisheye":
            found: Any = cv2.fisheye.stereoRectify(*lenses, full, *moved, flags)
        else:
            found = cv2.stereoRectify(*lenses, full, *moved, flags=flags, alpha=0)
    except cv2.error as error:
        raise ValueError("expected eyes that can be rectified, got such that OpenCV refuses") from error
    first, second, new_left, new_right = found[:4]
    if not all(np.isfinite(each).all() for each in found[:4]) or not new_left[0, 0] > 0:
        raise ValueError("expected eyes that can be rectified, got such that share no view")
    if abs(new_right[1, 3]) > abs(new_right[0, 3]):
        raise ValueError("expected eyes beside each other, got one above the other")
    # OpenCV counts from the centre of the first pixel, which here is at 0.5.
    focal, cx, cy = float(new_left[0, 0]), float(new_left[0, 2]) + 0.5, float(new_left[1, 2]) + 0.5
    camera = Camera(focal, focal, cx, cy, *full).resized(*size)
    return Rectified((first, second), camera, float(abs(new_right[0, 3] / new_right[0, 0])))


def _require_shape(full: tuple[int, int] | None, size: tuple[int, int], pixel_aspect: float) -> None:
    """Raises ValueError: neither as stored nor as shown do the frames have the shape of the calibration's."""
    if full is None or any(alike(full, (aspect * size[0], size[1])) for aspect in (1.0, pixel_aspect)):
        return
    got = f"{full[0]}x{full[1]}, the images are {size[0]}x{size[1]}"
    raise ValueError(f"expected the calibration of such images, got one of {got}")


def alike(full: tuple[int, int], shape: tuple[float, float]) -> bool:
    """Whether images of two sizes have one shape."""
    return abs(full[0] * shape[1] - full[1] * shape[0]) <= SAME_SHAPE * full[0] * shape[1]


def _scaled(lens: LensCalibration, size: tuple[int, int]) -> LensCalibration:
    """Of images of that size. Raises ValueError: the middle is not in them."""
    full = lens.size or size
    across, down = size[0] / full[0], size[1] / full[1]
    cx, cy = (lens.cx + 0.5) * across - 0.5, (lens.cy + 0.5) * down - 0.5
    if not (0 < cx < size[0] and 0 < cy < size[1]):
        middle = f"({lens.cx:.0f}, {lens.cy:.0f})"
        raise ValueError(f"expected the middle of the view within {size[0]}x{size[1]}, got it at {middle}")
    return replace(lens, fx=lens.fx * across, fy=lens.fy * down, cx=cx, cy=cy, size=size)


def _zoom(lens: LensCalibration, size: tuple[int, int]) -> float:
    """The least times its focal length with which nothing beyond the lens's image is shown."""
    width, height = size
    across, down = np.linspace(-0.5, width - 0.5, _ALONG), np.linspace(-0.5, height - 0.5, _ALONG)
    sides = [np.c_[across, np.full(_ALONG, y)] for y in (-0.5, height - 0.5)]
    sides += [np.c_[np.full(_ALONG, x), down] for x in (-0.5, width - 0.5)]
    border = (np.concatenate(sides) - (lens.cx, lens.cy)) / (lens.fx, lens.fy)
    best, reach = 0.0, np.zeros(len(border))
    for zoom in _ZOOMS:
        slants = border / zoom
        shown = _shown(lens, slants)
        out = np.linalg.norm((shown - (lens.cx, lens.cy)) / (lens.fx, lens.fy), axis=1)
        inside = ((shown > -0.51) & (shown < np.array(size) - 0.49)).all()
        if not inside or np.linalg.norm(slants, axis=1).max() > math.tan(WIDEST):
            break
        if not (out > reach).all():  # The polynomial turns back: beyond what it was fitted to.
            best = 0.0
            break
        best, reach = float(zoom), out
    if not best:
        raise ValueError("expected a distortion that holds to the image's border, got one that folds it")
    return best


def _shown(lens: LensCalibration, slants: FloatArray) -> FloatArray:
    """(N, 2) px, as OpenCV counts, of rays (N, 2): x and y where z is 1."""
    rays = np.c_[slants, np.ones(len(slants))][:, None]
    none = np.zeros(3)
    if lens.model == "fisheye":
        found: Any = cv2.fisheye.projectPoints(rays, none, none, lens.matrix, lens.coefficients)[0]
    else:
        found = cv2.projectPoints(rays, none, none, lens.matrix, lens.coefficients)[0]
    return np.asarray(found).reshape(-1, 2)


def _straightening(lens: LensCalibration, turn: FloatArray, camera: Camera) -> Straightening:
    to = camera.intrinsics.copy()
    to[:2, 2] -= 0.5
    size = camera.width, camera.height
    build: Any = (
        cv2.fisheye.initUndistortRectifyMap if lens.model == "fisheye" else cv2.initUndistortRectifyMap
    )
    places, fractions = build(lens.matrix, lens.coefficients, turn, to, size, cv2.CV_16SC2)
    return Straightening(camera, places, fractions)
