"""The training loss and its adjoint for the raster."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from renderer.depth.alignment import aligned
from renderer.rasterize.binning import TILE
from renderer.rasterize.cpu import Rasterizer
from renderer.rasterize.tiles import (
    ADJOINT_PLANES,
    BY_BLUE,
    BY_DEPTH,
    BY_GREEN,
    BY_RED,
    BY_WEIGHT,
    LEFT,
    PLANE_BLUE,
    PLANE_DEPTH,
    PLANE_GREEN,
    PLANE_RED,
    PLANES,
    TOTAL,
)
from renderer.stack_arrays import stack_array
from renderer.train.frames import TrainFrame
from renderer.train.variation import add_variation

# Columns of the sums that each picture row leaves.
COLOR_LOSS, DEPTH_LOSS, INVERSE_LOSS, SQUARED_ERROR, OPACITY_LOSS = range(5)
N_SUMS = 5
ZERO, ONE, HALF = np.float32(0.0), np.float32(1.0), np.float32(0.5)
BYTE = np.float32(1.0 / 255.0)
CLEAR = np.float32(0.02)
"""Share of the light that tissue may let through: what stands behind it does not show."""
SPARSE = slice(None, None, 4), slice(None, None, 4)
"""Rows and columns of a guessed depth that are compared with what is drawn."""
FEWEST_GUESSES = 50


@dataclass(frozen=True, kw_only=True)
class LossWeights:
    """What the loss adds up; each term is a mean over the pixels that it is of."""

    color: float = 1.0
    """Of |colour - image| over tissue and channels."""
    opacity: float = 0.0
    """Of max(0, 1 - alpha - CLEAR) over tissue, and of alpha where no frame shows tissue."""
    depth: float = 0.0
    """Of |depth - measured| / scene size."""
    inverse_depth: float = 0.0
    """Of |1 / depth - 1 / measured| times the scene size."""
    image_variation: float = 0.0
    """Of the total variation of the whole picture, tools and all."""
    inverse_depth_variation: float = 0.0
    """Of that of 1 / depth, times the scene size."""

    @property
    def takes_whole_picture(self) -> bool:
        """Every tile must be drawn, not only those with tissue."""
        return self.image_variation > 0 or self.inverse_depth_variation > 0


@dataclass(frozen=True)
class Measured:
    """What one step measured before its update."""

    loss: float
    squared_error: float
    """Mean over supervised pixels and channels."""


def picture_loss(rasterizer: Rasterizer, frame: TrainFrame, weights: LossWeights, size: float) -> Measured:
    """The loss of the picture that `rasterizer` holds; its adjoint is left there. `size` is the scene's."""
    per_color = 1.0 / max(3 * frame.n_colors, 1)
    per_opacity = weights.opacity / max(frame.n_opaque + frame.n_unseen, 1)
    per_depth = weights.depth / (max(frame.n_depths, 1) * size)
    per_inverse = weights.inverse_depth * size / max(frame.n_depths, 1)
    rows = np.empty((frame.color_mask.shape[0], N_SUMS))
    loss, extra = _variation(rasterizer.planes, frame, weights, size)
    depth = _fitted(rasterizer.planes, frame) if frame.depth_is_guess else frame.depth
    masked_loss(
        rasterizer.planes, frame.colors, frame.color_mask, frame.opaque, frame.unseen, depth,
        rasterizer.wanted, weights.color * per_color, per_opacity, per_depth, per_inverse, extra,
        rasterizer.adjoint, rows,
    )  # fmt: skip
    sums = rows.sum(axis=0)
    loss += weights.color * per_color * sums[COLOR_LOSS] + per_opacity * sums[OPACITY_LOSS]
    loss += per_depth * sums[DEPTH_LOSS] + per_inverse * sums[INVERSE_LOSS]
    return Measured(float(loss), float(per_color * sums[SQUARED_ERROR]))


def _fitted(planes: NDArray[np.float32], frame: TrainFrame) -> NDArray[np.float32]:
    """A guessed depth, its inverse scaled and shifted to what is drawn: only its shape supervises."""
    light, drawn = ONE - planes[LEFT][SPARSE], planes[PLANE_DEPTH][SPARSE]
    scale, shift = guess_line(frame.depth[SPARSE], light, drawn)
    inverse = np.float32(scale) / np.where(frame.depth > 0, frame.depth, ONE) + np.float32(shift)
    usable = (frame.depth > 0) & (inverse > 0) & (scale > 0)
    return np.where(usable, ONE / np.where(usable, inverse, ONE), ZERO)


def guess_line(
    guess: NDArray[np.float32], light: NDArray[np.float32], drawn: NDArray[np.float32]
) -> tuple[float, float]:
    """Scale and shift that take the inverse of a guessed depth to that of what is drawn; scale 0: too little.

    All are of one shape: `light` the alpha of what is drawn, `drawn` its depth times that.
    """
    compared = (guess > 0) & (light > HALF)
    if np.count_nonzero(compared) < FEWEST_GUESSES:
        return 0.0, 0.0
    inverse_drawn = light / np.where(compared, drawn, ONE)
    return aligned(ONE / np.where(guess > 0, guess, ONE), inverse_drawn, compared)


def _variation(
    planes: NDArray[np.float32], frame: TrainFrame, weights: LossWeights, size: float
) -> tuple[float, NDArray[np.float32]]:
    """The terms over neighbourhoods and their gradient, (4, H, W) or, where there is none, empty."""
    if not weights.takes_whole_picture:
        return 0.0, np.empty((0, 0, 0), np.float32)
    extra = np.zeros((4, *planes.shape[1:]), np.float32)
    inside = slice(frame.camera.height), slice(frame.camera.width)
    loss = add_variation(
        planes[:, *inside], weights.image_variation, weights.inverse_depth_variation * size,
        extra[:, *inside],
    )  # fmt: skip
    return loss, extra


@njit(inline="always")
def _sign(value: np.float32) -> np.float32:
    return ONE if value > ZERO else (-ONE if value < ZERO else ZERO)


@njit(parallel=True, cache=True, error_model="numpy")
def masked_loss(
    planes: NDArray[np.float32],  # (5, H, W) blended picture, black background
    colors: NDArray[np.uint8],  # (3, H, W)
    color_mask: NDArray[np.bool_],  # (H, W)
    opaque: NDArray[np.bool_],  # (H, W)
    unseen: NDArray[np.bool_],  # (H, W)
    depths: NDArray[np.float32],  # (H, W), 0 = not supervised
    tile_wanted: NDArray[np.bool_],
    color_weight: float,
    opacity_weight: float,
    depth_weight: float,
    inverse_weight: float,
    extra: NDArray[np.float32],  # (4, H, W) gradient by colours and depth of other terms, or empty
    adjoint: NDArray[np.float32],  # (6, H, W), out on the wanted tiles
    sums: NDArray[np.float64],  # (H, N_SUMS), out: unweighted, of the absolute errors and the squared ones
) -> None:
    """L1 of colour on tissue, of alpha, and of expected depth where it is measured and alpha > 0.5.

    Loss = color_weight * sum |color - image|
    + opacity_weight * (sum max(0, 1 - alpha - CLEAR) over what is opaque + sum alpha over what is unseen)
    + depth_weight * sum |D - depth| + inverse_weight * sum |1 / D - 1 / depth| with D = sum(w z) / sum(w).
    """
    for y in prange(planes.shape[1]):
        _row_loss(
            planes[:, y], colors[:, y], color_mask[y], opaque[y], unseen[y], depths[y],
            tile_wanted[y // TILE], np.float32(color_weight), np.float32(opacity_weight),
            np.float32(depth_weight), np.float32(inverse_weight),
            adjoint[:, y], sums[y],
        )  # fmt: skip
        if len(extra) > 0:
            for x in range(planes.shape[2]):
                if tile_wanted[y // TILE, x // TILE]:
                    _add_extra(planes, extra, y, x, adjoint)


@njit(fastmath={"contract"}, error_model="numpy")
def _row_loss(
    planes: NDArray[np.float32],  # (5, W)
    colors: NDArray[np.uint8],  # (3, W)
    color_mask: NDArray[np.bool_],
    opaque: NDArray[np.bool_],
    unseen: NDArray[np.bool_],
    depths: NDArray[np.float32],
    wanted: NDArray[np.bool_],  # one a tile
    color_gradient: np.float32,
    opacity_gradient: np.float32,
    depth_gradient: np.float32,
    inverse_gradient: np.float32,
    adjoint: NDArray[np.float32],  # (6, W), out
    sums: NDArray[np.float64],  # (N_SUMS,), out
) -> None:
    """One row, a tile's width at a time: fetched to the stack, reckoned there as vectors, and put back."""
    drawn, image = stack_array(PLANES, TILE), stack_array(3, TILE)
    by, lanes = stack_array(ADJOINT_PLANES, TILE), stack_array(N_SUMS, TILE)
    kept, full, empty, measured = stack_array(TILE), stack_array(TILE), stack_array(TILE), stack_array(TILE)
    for row in range(N_SUMS):
        for lane in range(TILE):
            lanes[row, lane] = ZERO
    for tile in range(len(wanted)):
        if not wanted[tile]:
            continue
        left = TILE * tile
        for lane in range(TILE):
            kept[lane] = ONE if color_mask[left + lane] else ZERO
            full[lane] = ONE if opaque[left + lane] else ZERO
            empty[lane] = ONE if unseen[left + lane] else ZERO
            measured[lane] = depths[left + lane]
            for plane in range(PLANES):
                drawn[plane, lane] = planes[plane, left + lane]
            for channel in range(3):
                image[channel, lane] = np.float32(colors[channel, left + lane]) * BYTE
        for lane in range(TILE):
            keep = kept[lane]
            red = (drawn[PLANE_RED, lane] - image[0, lane]) * keep
            green = (drawn[PLANE_GREEN, lane] - image[1, lane]) * keep
            blue = (drawn[PLANE_BLUE, lane] - image[2, lane]) * keep
            lanes[COLOR_LOSS, lane] += abs(red) + abs(green) + abs(blue)
            lanes[SQUARED_ERROR, lane] += red * red + green * green + blue * blue
            by_red = color_gradient * _sign(red)
            by_green = color_gradient * _sign(green)
            by_blue = color_gradient * _sign(blue)
            by[BY_RED, lane], by[BY_GREEN, lane], by[BY_BLUE, lane] = by_red, by_green, by_blue
            weight, depth = ONE - drawn[LEFT, lane], measured[lane]
            through = drawn[LEFT, lane] - CLEAR
            shines = full[lane] > ZERO and through > ZERO
            lanes[OPACITY_LOSS, lane] += (through if shines else ZERO) + empty[lane] * weight
            by_opacity = opacity_gradient * (empty[lane] - (ONE if shines else ZERO))
            # The depth terms of the total cancel: sum(w z) h - sum(w) D h = 0.
            by[TOTAL, lane] = (
                drawn[PLANE_RED, lane] * by_red
                + drawn[PLANE_GREEN, lane] * by_green
                + drawn[PLANE_BLUE, lane] * by_blue
                + weight * by_opacity
            )
            compared = keep > ZERO and depth > ZERO and weight > HALF
            weight = weight if compared else ONE
            depth = depth if compared else ONE
            expected = drawn[PLANE_DEPTH, lane] / weight if compared else ONE
            error, nearness = expected - depth, ONE / depth - ONE / expected
            lanes[DEPTH_LOSS, lane] += abs(error)
            lanes[INVERSE_LOSS, lane] += abs(nearness)
            slope = depth_gradient + inverse_gradient / (expected * expected)
            by_depth = slope * _sign(error) / weight
            by[BY_DEPTH, lane] = by_depth
            by[BY_WEIGHT, lane] = by_opacity - by_depth * expected
        for plane in range(ADJOINT_PLANES):
            for lane in range(TILE):
                adjoint[plane, left + lane] = by[plane, lane]
    for row in range(N_SUMS):
        sums[row] = 0.0
        for lane in range(TILE):
            sums[row] += np.float64(lanes[row, lane])


@njit(inline="always")
def _add_extra(
    planes: NDArray[np.float32], extra: NDArray[np.float32], y: int, x: int, adjoint: NDArray[np.float32]
) -> None:
    for c in range(3):
        adjoint[BY_RED + c, y, x] += extra[c, y, x]
        adjoint[TOTAL, y, x] += planes[PLANE_RED + c, y, x] * extra[c, y, x]
    weight = ONE - planes[LEFT, y, x]
    if weight > HALF:
        by_depth = extra[3, y, x] / weight
        adjoint[BY_DEPTH, y, x] += by_depth
        adjoint[BY_WEIGHT, y, x] -= by_depth * planes[PLANE_DEPTH, y, x] / weight
