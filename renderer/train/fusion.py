"""Motion-aware point fusion of Deform3DGS (Yang et al., MICCAI 2024, section 2.3): the initial Gaussians."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from renderer.camera import FloatArray
from renderer.clip import BoolImage, Frame
from renderer.raw_gaussians import RawGaussians
from renderer.splats import Float32Array
from renderer.train.config import TrainConfig
from renderer.train.initialize import round_gaussians, scene_size
from renderer.train.neighbours import neighbour_distances

OPACITY = 0.1
OF_REFERENCE, OF_OTHERS = (0.1, 99.9), (3.0, 99.8)
"""Percentiles of a frame's depth beyond which it is not taken."""
MANY_FRAMES, STRIDE = 150, 2
FEWEST = 50
"""A frame that adds no more pixels than these adds none."""
SHARE = 0.1
"""Of the points of the other frames."""
RESTLESS = 95.0
"""Percentile of the differences to the mean picture from which a pixel counts as moving."""
SAMPLED = 4
"""Rows and columns from one pixel to the next whose differences the percentile is of."""
MOST_SAMPLED = 500
"""Frames that it is of: of longer clips, some at equal distances."""
SMALLEST = 5e-6
"""Standard deviation in scene sizes, where points coincide."""

Cloud = tuple[Float32Array, Float32Array]
"""World positions (P, 3) and colours (P, 3) in [0, 1]."""


def fused(frames: Sequence[Frame], config: TrainConfig) -> RawGaussians:
    """`n_gaussians` balls on the tissue: of the first frame, and of others where it is hidden or moves.

    Points are drawn without repetition, so a clip with less tissue than that gives fewer. They lie behind
    the centres of their pixels; their size is the distance to the three nearest.

    Raises:
        ClipError: no frame has depth on tissue.
    """
    smallest = SMALLEST * scene_size(frames)
    rng = np.random.default_rng(config.seed)
    points, colors = (np.concatenate(column) for column in zip(*_clouds(frames, rng), strict=True))
    chosen = rng.permutation(len(points))[: config.n_gaussians]
    means = points[chosen]
    scales = np.maximum(neighbour_distances(means), smallest)
    return round_gaussians(means, scales, colors[chosen], OPACITY)


def _clouds(frames: Sequence[Frame], rng: np.random.Generator) -> Iterable[Cloud]:
    """Of the first frame with depth, then of what each other frame adds in its view."""
    first, *others = [place for place, frame in enumerate(frames) if frame.depth_mask.any()]
    reference = frames[first]
    covered = reliable(reference, OF_REFERENCE)
    yield _cloud(reference, np.flatnonzero(covered))
    moving = restless(frames, reference)
    for place in others[:: STRIDE if len(frames) > MANY_FRAMES else 1]:
        frame = frames[place]
        candidates = np.flatnonzero(reliable(frame, OF_OTHERS))
        cell = _cells(frame, candidates, reference)
        new = (cell >= 0) & (moving | ~covered).reshape(-1)[cell]
        if np.count_nonzero(new) <= FEWEST:
            continue
        covered.reshape(-1)[cell[new]] = True
        added = candidates[new]
        yield _cloud(frame, rng.choice(added, round(SHARE * len(added)), replace=False))


def reliable(frame: Frame, percentiles: tuple[float, float]) -> BoolImage:
    """Where tissue has depth (H, W) within these percentiles of it; ends are stereo error more often."""
    mask = frame.depth_mask
    if frame.depth is None or not mask.any():
        return mask
    lowest, highest = np.percentile(frame.depth[mask], percentiles)
    kept: BoolImage = mask & (frame.depth >= lowest) & (frame.depth <= highest)
    return kept


def restless(frames: Sequence[Frame], reference: Frame) -> BoolImage:
    """Where the reference (H, W) differs from the mean picture as only the top 5 % of all pixels do."""
    mean = reduce(np.add, (_grey(frame) for frame in frames)) / np.float32(len(frames))
    looked_at = (frames[place] for place in range(0, len(frames), -(-len(frames) // MOST_SAMPLED)))
    sample = np.stack([np.abs(_grey(frame) - mean)[::SAMPLED, ::SAMPLED] for frame in looked_at])
    threshold = np.percentile(sample[sample > 0], RESTLESS) if sample.any() else 0.0
    moving: BoolImage = np.abs(_grey(reference) - mean) > threshold
    return moving


def _grey(frame: Frame) -> Float32Array:
    """Mean of the channels (H, W)."""
    grey: Float32Array = frame.image.mean(axis=2, dtype=np.float32)
    return grey


def _cloud(frame: Frame, pixels: NDArray[np.int64]) -> Cloud:
    """Behind the centres of these pixels, numbered row by row."""
    colors = frame.image.reshape(-1, 3)[pixels].astype(np.float32) / np.float32(255)
    return _positions(frame, pixels).astype(np.float32), colors


def _positions(frame: Frame, pixels: NDArray[np.int64]) -> FloatArray:
    """(P, 3) in the world."""
    assert frame.depth is not None
    return frame.camera.unproject(frame.depth).reshape(-1, 3)[pixels]


def _cells(frame: Frame, pixels: NDArray[np.int64], reference: Frame) -> NDArray[np.int64]:
    """The pixel of the reference (P,) in which it sees what the frame has in these; -1 outside its view."""
    if frame.camera == reference.camera:
        return pixels
    camera = reference.camera
    positions, depth = camera.project(_positions(frame, pixels))
    inside = (
        (depth > 0) & (positions >= 0).all(axis=1) & (positions < (camera.width, camera.height)).all(axis=1)
    )
    column, row = np.where(inside[:, None], positions, 0).astype(np.int64).T
    return np.where(inside, row * camera.width + column, -1)
