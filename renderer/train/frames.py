"""Training frames ready for the kernels: padded to whole tiles, uint8 colours, masks, wanted tiles."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import reduce

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.clip import Frame
from renderer.frame_gains import steadied
from renderer.rasterize.binning import TILE

MARGIN = 3
"""Pixels that an edge takes to fall from tissue to nothing. Chosen on frames held out of training (1000
steps, seed 0, pulling and mesentery): without, tissue that few frames show is 5 dB worse on the latter; with
2 and 4, 2.4 and 1 dB."""

BEYOND = 100.0
"""Times the median depth of a frame's tissue: far more than any view of a body spans."""


@dataclass(frozen=True, eq=False)
class TrainFrame:
    """One supervised view; arrays are padded at the right and bottom to multiples of TILE."""

    time: float
    camera: Camera
    colors: NDArray[np.uint8]  # (3, H, W)
    color_mask: NDArray[np.bool_]  # (H, W)
    opaque: NDArray[np.bool_]  # (H, W), True: this frame or another shows tissue there; on wanted tiles
    unseen: NDArray[np.bool_]  # (H, W), True: no frame shows tissue there; on wanted tiles
    depth: NDArray[np.float32]  # (H, W), 0 = not supervised
    tile_wanted: NDArray[np.bool_]  # (tile rows, tile columns)
    n_colors: int
    """Supervised pixels."""
    n_opaque: int
    """Pixels that tissue is to hide what is behind."""
    n_unseen: int
    n_depths: int
    depth_is_guess: bool

    @property
    def tissue(self) -> NDArray[np.bool_]:
        """(H, W) the mask of colours without the padding."""
        return self.color_mask[: self.camera.height, : self.camera.width]


def within_reach(frame: Frame) -> Frame:
    """The frame without depth that is no depth of tissue, as where a program writes a huge number for none;
    the same frame where there is none such."""
    if frame.depth is None or (median := frame.median_depth) is None:
        return frame
    near = frame.depth <= BEYOND * median
    return frame if near.all() else replace(frame, depth=np.where(near, frame.depth, np.float32(0)))


def as_fitted(frame: Frame) -> Frame:
    """The frame that training sees: in the clip's common exposure, within reach."""
    return steadied(within_reach(frame))


def train_frame(
    frame: Frame, unseen: NDArray[np.bool_] | None = None, seen: NDArray[np.bool_] | None = None
) -> TrainFrame:
    """A frame at its own resolution. Only tissue is supervised, and depth only where it is measured.

    `unseen` (H, W) is where no frame shows tissue, `seen` where some does; None: that is not known.
    """
    depth = np.zeros(frame.tissue_mask.shape, np.float32) if frame.depth is None else frame.depth
    depth = np.where(frame.depth_mask, depth, np.float32(0.0))
    unseen = np.zeros(depth.shape, bool) if unseen is None else unseen
    seen = frame.tissue_mask if seen is None else seen
    masks = frame.tissue_mask, seen, unseen
    return _padded(frame.time, frame.camera, frame.image, *masks, depth, frame.depth_is_guess)


def seen_by(frames: Iterable[Frame]) -> NDArray[np.bool_]:
    """(H, W) where some of the frames shows tissue."""
    return reduce(np.logical_or, (frame.tissue_mask for frame in frames))


def unseen_beyond(seen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(H, W) where no frame of a fixed camera shows tissue within MARGIN; `seen` (H, W): where some does."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * MARGIN + 1, 2 * MARGIN + 1))
    reached: NDArray[np.bool_] = cv2.dilate(seen.astype(np.uint8), disc) > 0
    return ~reached


def away_from_tools(tissue: NDArray[np.bool_]) -> NDArray[np.float32]:
    """(H, W) distance of each pixel from the nearest that is no tissue; the image's own border is no edge."""
    padded = np.pad(tissue.astype(np.uint8), 1, constant_values=1)
    away = cv2.distanceTransform(padded, cv2.DIST_L2, cv2.DIST_MASK_5)
    return np.asarray(away[1:-1, 1:-1], np.float32)


def tissue_tiles(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(tile rows, tile columns) of a mask (H, W), True = some pixel of the tile is True."""
    below, beside = (-length % TILE for length in mask.shape)
    padded = np.pad(mask, ((0, below), (0, beside)))
    rows, columns = (length // TILE for length in padded.shape)
    tiles: NDArray[np.bool_] = np.logical_or.reduce(padded.reshape(rows, TILE, columns, TILE), axis=(1, 3))
    return tiles


def halved(frame: TrainFrame, has_masks: bool = True) -> TrainFrame:
    """The frame at half resolution: means over each 2x2 block, of supervised pixels where it has masks."""
    width, height = frame.camera.width, frame.camera.height
    half = (max(width // 2, 1), max(height // 2, 1))
    mask = frame.color_mask[:height, :width].astype(np.float32)
    colors = frame.colors[:, :height, :width].transpose(1, 2, 0).astype(np.float32)
    if has_masks:
        colors = _masked_mean(colors, mask, half)
    else:
        colors = cv2.resize(colors, half, interpolation=cv2.INTER_AREA).astype(np.float32)
    depth_values = frame.depth[:height, :width]
    depth = _masked_mean(depth_values, (depth_values > 0).astype(np.float32), half)
    tissue = cv2.resize(mask, half, interpolation=cv2.INTER_AREA) >= 0.5
    unseen = cv2.resize(frame.unseen[:height, :width].astype(np.float32), half, interpolation=cv2.INTER_AREA)
    opaque = cv2.resize(frame.opaque[:height, :width].astype(np.float32), half, interpolation=cv2.INTER_AREA)
    camera = frame.camera.resized(*half)
    bytes_, known = np.rint(colors).astype(np.uint8), np.where(tissue, depth, 0.0)
    return _padded(
        frame.time, camera, bytes_, tissue, opaque >= 0.5, unseen == 1, known, frame.depth_is_guess
    )


def _masked_mean(
    values: NDArray[np.float32], mask: NDArray[np.float32], size: tuple[int, int]
) -> NDArray[np.float32]:
    """Area mean over True pixels; 0 where they cover less than half of the area."""
    share = cv2.resize(mask, size, interpolation=cv2.INTER_AREA)
    weights = mask[:, :, None] if values.ndim == 3 else mask
    total = cv2.resize(values * weights, size, interpolation=cv2.INTER_AREA)
    known = share >= 0.5
    divisor = np.where(known, share, 1.0)
    known_3d, divisor_3d = (known[:, :, None], divisor[:, :, None]) if values.ndim == 3 else (known, divisor)
    return np.where(known_3d, total / divisor_3d, 0.0).astype(np.float32)


def _padded(
    time: float,
    camera: Camera,
    colors: NDArray[np.uint8],
    mask: NDArray[np.bool_],
    opaque: NDArray[np.bool_],
    unseen: NDArray[np.bool_],
    depth: NDArray[np.float32],
    depth_is_guess: bool,
) -> TrainFrame:
    rows, columns = -(-camera.height // TILE), -(-camera.width // TILE)
    below, beside = rows * TILE - camera.height, columns * TILE - camera.width
    mask = np.pad(mask, ((0, below), (0, beside)))
    depth = np.pad(depth.astype(np.float32), ((0, below), (0, beside)))
    wanted = tissue_tiles(mask)
    unseen = np.pad(unseen, ((0, below), (0, beside)))
    opaque = np.pad(opaque, ((0, below), (0, beside)))
    height, width = mask.shape
    drawn = wanted.repeat(TILE, axis=0).repeat(TILE, axis=1)[:height, :width]
    unseen &= drawn
    opaque &= drawn
    return TrainFrame(
        time=time,
        camera=camera,
        colors=np.pad(colors.transpose(2, 0, 1), ((0, 0), (0, below), (0, beside))),
        color_mask=mask,
        opaque=opaque,
        unseen=unseen,
        depth=depth,
        tile_wanted=wanted,
        n_colors=int(mask.sum()),
        n_opaque=int(opaque.sum()),
        n_unseen=int(unseen.sum()),
        n_depths=int((depth > 0).sum()),
        depth_is_guess=depth_is_guess,
    )
