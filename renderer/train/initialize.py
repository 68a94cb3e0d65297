"""Gaussians from the measured depth of the training frames."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from renderer.clip import Clip, ClipError, Frame, SparsePoints
from renderer.depth.sparse_depth import depth_between
from renderer.raw_gaussians import RawGaussians
from renderer.train.config import TrainConfig

Float32Array = NDArray[np.float32]

MOST_DISTANT = 1e9
"""Depth in the clip's unit; the reciprocal is the least."""
RESOLVED = 0.5
"""Of a pixel on the tissue, by which float32 may round a position."""
# Depth at both ends of a frame's range is stereo error more often than tissue.
LOWEST_PERCENTILE, HIGHEST_PERCENTILE = 0.1, 99.9


def with_points(frames: Iterable[Frame], points: SparsePoints | None) -> Iterator[Frame]:
    """The frames to start from: those without depth get what is between the sparse points they see."""
    for frame in frames:
        if points is None or frame.depth is not None:
            yield frame
        else:
            yield replace(frame, depth=depth_between(points.positions, frame.camera, frame.tissue_mask))


def scene_size(frames: Iterable[Frame]) -> float:
    """Median depth of the tissue in the clip's unit: every length in training is relative to it.

    Raises:
        ClipError: no frame has depth on tissue, or that is no length that can be calculated with.
    """
    medians = [float(np.median(frame.depth[frame.depth_mask])) for frame in frames if _has_depth(frame)]  # type: ignore[index]
    if not medians:
        raise ClipError("reconstruction expects measured depth on the tissue, and this clip has none")
    size = float(np.median(medians))
    if not 1 / MOST_DISTANT < size < MOST_DISTANT:
        least = f"{1 / MOST_DISTANT:g} to {MOST_DISTANT:g}"
        raise ClipError(f"expected tissue at a depth of {least}, got a median of {size:g}")
    return size


def require_resolved(clip: Clip, size: float) -> None:
    """Raises ClipError where cameras are so far from the origin that float32 cannot tell pixels apart."""
    pixel = size / max(camera.fx for camera in clip.cameras)
    most = RESOLVED * pixel / float(np.finfo(np.float32).eps)
    farthest = max(float(np.abs(camera.position).max()) for camera in clip.cameras)
    if not farthest <= most:
        expected = f"expected cameras within {most:.3g} of the origin, where float32 resolves pixels"
        raise ClipError(f"{expected}; got one at {farthest:.3g}: {clip.path}")


def sampled(frames: Sequence[Frame], config: TrainConfig) -> RawGaussians:
    """Random tissue pixels of the given frames in equal shares, placed behind the centre of their pixel.

    A Gaussian's size follows from the spacing that the samples have on the tissue at its depth.
    """
    rng = np.random.default_rng(config.seed)
    # The frames themselves may be more than memory holds.
    covered = {place: int(frame.depth_mask.sum()) for place, frame in enumerate(frames)}
    measured = [place for place, count in covered.items() if count]
    shares = np.full(len(measured), config.n_gaussians // len(measured))
    shares[: config.n_gaussians % len(measured)] += 1
    parts = [_sample(frames[place], int(share), rng) for place, share in zip(measured, shares, strict=True)]
    means, pixel_sizes, colors = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    spacing = np.sqrt(np.mean([covered[place] for place in measured]) / len(means)) * pixel_sizes
    scales = config.initial_spacing * spacing
    return round_gaussians(means, scales, colors, config.initial_opacity)


def round_gaussians(
    means: Float32Array, scales: NDArray[np.floating[Any]], colors: Float32Array, opacity: float
) -> RawGaussians:
    """Balls (N,) of one opacity, the same from all sides."""
    quats = np.zeros((len(means), 4), np.float32)
    quats[:, 0] = 1.0
    return RawGaussians(
        means=means,
        quats=quats,
        log_scales=np.log(scales)[:, None].repeat(3, axis=1).astype(np.float32),
        opacity_logits=np.full(len(means), np.log(opacity / (1 - opacity)), np.float32),
        colors=colors,
        harmonics=np.zeros((len(means), 0, 3), np.float32),
    )


def _has_depth(frame: Frame) -> bool:
    return bool(frame.depth_mask.any())


def _sample(
    frame: Frame, share: int, rng: np.random.Generator
) -> tuple[Float32Array, Float32Array, Float32Array]:
    """World positions (S, 3), size of a pixel at their depth (S,) and colours (S, 3), S <= share."""
    assert frame.depth is not None
    measured = frame.depth[frame.depth_mask]
    lowest, highest = np.percentile(measured, (LOWEST_PERCENTILE, HIGHEST_PERCENTILE))
    candidates = np.flatnonzero(frame.depth_mask & (frame.depth >= lowest) & (frame.depth <= highest))
    chosen = rng.choice(candidates, min(share, len(candidates)), replace=False)
    points = frame.camera.unproject(frame.depth).reshape(-1, 3)[chosen]
    colors = frame.image.reshape(-1, 3)[chosen] / np.float32(255)
    pixel_sizes = frame.depth.reshape(-1)[chosen] / np.float32(frame.camera.fx)
    return points.astype(np.float32), pixel_sizes, colors
