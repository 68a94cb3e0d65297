"""Which tissue the training frames show, and how often; specks where hardly any was seen."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.clip import BoolImage, ByteImage, Clip, Frame
from renderer.splats import Float32Array
from renderer.unobserved import GREY

Pixels = tuple[NDArray[np.int64], ...]
"""Their rows (N,) and columns (N,)."""

SELDOM: Final = 0.3
"""Tissue that at most this share of the training frames shows is seldom seen."""
NEAR: Final = 20
"""Pixels from the edge of what was ever seen, on both sides, where specks are looked for."""
AROUND: Final = 11
"""Side in pixels of the window whose median a speck differs from."""
GLARING: Final = 40
"""Grey levels, in some channel, by which it differs."""
STRAYS: Final = 3
"""Pixels that a highlight, or any colour of tissue, may lie beside where a frame shows it."""
ALIKE: Final = 16
"""Grey levels, in each channel, by which tissue of one colour differs from frame to frame. Of what glares
near the edge in training frames, 91 % (pulling) and 97 % (mesentery) differs by no more from tissue that
another training frame shows within STRAYS; of all the tissue there more than 99.9 %."""
SOLID: Final = 0.5
"""Alpha of tissue, against what is clear."""
BODY: Final = 5
"""Radius in pixels of a disc that fits into observed tissue; what is narrower is compared with all around."""


def shares_seen(clip: Clip, fit: Sequence[int]) -> NDArray[np.float64] | None:
    """(H, W) share of the frames `fit` that show tissue in a pixel; None where the camera moves, so that a
    pixel is no place."""
    if not clip.camera_is_fixed:
        return None
    shown = np.zeros(clip.size[::-1])
    for mask in tissue_masks(clip, fit):
        shown += mask
    return shown / max(len(fit), 1)


def tissue_masks(clip: Clip, fit: Sequence[int]) -> Iterator[BoolImage]:
    """(H, W) True where tissue is shown, of one frame after the other."""
    return (clip.read_frame(index).tissue_mask for index in fit)


def is_seldom(shares: NDArray[np.float64]) -> BoolImage:
    """(H, W), True where few frames show tissue, and some."""
    return np.asarray((shares > 0) & (shares <= SELDOM))


def seldom_seen(clip: Clip, fit: Sequence[int]) -> BoolImage | None:
    """(H, W), True where few of the frames `fit` show tissue, and some; None where the camera moves."""
    shares = shares_seen(clip, fit)
    return None if shares is None else is_seldom(shares)


def highlights(clip: Clip, fit: Sequence[int]) -> BoolImage:
    """(H, W) True where tissue differs glaringly from what is around it in some of the frames `fit`, or
    within STRAYS of that."""
    width, height = clip.size
    found = np.zeros((height, width), bool)
    for index in fit:
        frame = clip.read_frame(index)
        found |= frame.tissue_mask & _glaring(frame.image)
    return cv2.dilate(found.astype(np.uint8), _disc(STRAYS)) > 0


def recorded(render: ByteImage, frame: Frame) -> BoolImage:
    """(H, W) True where each channel of a render of the frame lies between those of the tissue that the frame
    itself shows within STRAYS: it differs from its surroundings as the tissue does."""
    tissue, disc = frame.tissue_mask[..., None], _disc(STRAYS)
    least = cv2.erode(np.where(tissue, frame.image, np.uint8(255)), disc)
    most = cv2.dilate(np.where(tissue, frame.image, np.uint8(0)), disc)
    return np.asarray(((render >= least) & (render <= most)).all(axis=2))


def specks(
    render: ByteImage,
    alpha: Float32Array,
    seen: BoolImage,
    shown: BoolImage,
    frames: Iterable[Frame] = (),
) -> int:
    """Pixels that differ glaringly from those around them, near the edge of what was ever seen (`seen`).

    What hangs together with tissue that was observed is compared with such tissue alone: at a corner most of
    what lies around is fill, which is no tissue. What floats in the fill is compared with all around it.

    What frames show so themselves (`shown`, see `highlights` and `recorded`) is no speck, and what looks like
    the grey that the render lies over, or like a mixture of that and what is around, is none but a place that
    was not observed, or its edge.

    Args:
        render: (H, W, 3), over GREY where its `alpha` (H, W) is below 1.
    """
    ever, disc = seen.astype(np.uint8), _disc(NEAR)
    edge = (cv2.dilate(ever, disc) > 0) & (cv2.erode(ever, disc, borderValue=1) == 0)
    solid = (alpha >= SOLID).astype(np.uint8)
    observed = (cv2.morphologyEx(solid, cv2.MORPH_OPEN, _disc(BODY)) > 0) & seen
    around = _around(render)
    partly = cv2.erode(observed.astype(np.uint8), np.ones((AROUND, AROUND), np.uint8)) == 0
    joined = _joined(solid, observed)
    at = np.nonzero(edge & ~shown & partly & joined)
    around[at] = _medians(render, observed, at)
    found = _is_no_mixture(render, around) & edge & ~shown
    return int(np.count_nonzero(found)) - _recalled(render, np.nonzero(found & joined), frames)


def _recalled(render: ByteImage, at: Pixels, frames: Iterable[Frame]) -> int:
    """How many of the pixels `at` are of a colour that one of the frames shows there."""
    if not len(at[0]):
        return 0
    reach = np.argwhere(_disc(STRAYS)) - STRAYS
    rows, columns = (
        (place[:, None] + step).clip(0, length - 1)
        for place, step, length in zip(at, reach.T, render.shape[:2], strict=True)
    )
    colors, recalled = render[at][:, None].astype(np.int16), np.zeros(len(rows), bool)
    for frame in frames:
        apart = np.abs(frame.image[rows, columns] - colors).max(axis=2)
        recalled |= ((apart <= ALIKE) & frame.tissue_mask[rows, columns]).any(axis=1)
    return int(np.count_nonzero(recalled))


def _joined(solid: ByteImage, observed: BoolImage) -> BoolImage:
    """(H, W) True of what is solid, hangs together with what was observed, and reaches STRAYS out of it."""
    count, parts = cv2.connectedComponents(solid, connectivity=4)
    held = np.zeros(count, bool)
    held[parts[observed]] = True
    near = cv2.dilate(observed.astype(np.uint8), _disc(STRAYS)) > 0
    return np.asarray(held[parts] & near)


def _medians(image: ByteImage, observed: BoolImage, at: Pixels) -> NDArray[np.float64]:
    """(N, 3) medians about the pixels `at` of what was observed there."""
    reach = AROUND // 2
    known = np.where(observed[..., None], image, np.nan).astype(np.float32)
    padded = np.pad(known, ((reach, reach), (reach, reach), (0, 0)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, (AROUND, AROUND), axis=(0, 1))[at]
    return np.asarray(np.nanmedian(windows.reshape(len(windows), 3, AROUND**2), axis=2))


def _disc(radius: int) -> ByteImage:
    side = 2 * radius + 1
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side)).astype(np.uint8)


def _glaring(image: ByteImage) -> BoolImage:
    apart = np.abs(image.astype(np.int16) - _around(image))
    return np.asarray(apart.max(axis=2) > GLARING)


def _is_no_mixture(image: ByteImage, medians: ByteImage) -> BoolImage:
    """(H, W) True where it differs glaringly from all that lies between its surroundings and GREY."""
    around = medians.astype(np.float32)
    to_grey, apart = np.float32(255) * np.array(GREY, np.float32) - around, image - around
    share = (apart * to_grey).sum(axis=2) / np.maximum((to_grey * to_grey).sum(axis=2), 1)
    left = apart - np.clip(share, 0, 1)[..., None] * to_grey
    return np.asarray(np.abs(left).max(axis=2) > GLARING)


def _around(image: ByteImage) -> ByteImage:
    """(H, W, 3) the median about each pixel."""
    medians = [cv2.medianBlur(np.ascontiguousarray(image[..., channel]), AROUND) for channel in range(3)]
    return np.stack(medians, axis=2)
