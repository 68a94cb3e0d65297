"""Gaussians from the measured depth of the training frames."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from renderer.clip import BoolImage, Clip, ClipError, Frame, SparsePoints
from renderer.depth.filled_depth import filled_depth
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
EVENNESS = 0.5
"""Share of the samples that are spread evenly over all pixels that any frame shows."""


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
    """Random tissue pixels of the given frames, placed behind the centre of their pixel.

    Half of the Gaussians are spread over the frames, so that what is often seen, and often judged, has the
    more of them; half over all pixels that any frame shows, so that what is seldom seen has no gaps. A
    Gaussian's size follows from the spacing that the samples have about its pixel.

    Where a frame has no depth on tissue, the depth around it places them (`filled_depth`).
    """
    rng = np.random.default_rng(config.seed)
    # The frames themselves may be more than memory holds.
    measured = [place for place in range(len(frames)) if _has_depth(frames[place])]
    density = Density.of(frames[place] for place in measured)
    totals = np.array([density.weights(frames[place].tissue_mask).sum() for place in measured])
    ends = np.rint(np.cumsum(totals) / totals.sum() * config.n_gaussians).astype(int)
    shares = np.diff(ends, prepend=0)
    parts = [
        _sample(frames[place], int(share), density, rng)
        for place, share in zip(measured, shares, strict=True)
    ]
    means, pixel_sizes, colors, densities = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    spacing = pixel_sizes / np.sqrt(len(means) * densities)
    return round_gaussians(means, config.initial_spacing * spacing, colors, config.initial_opacity)


@dataclass(frozen=True, eq=False)
class Density:
    """How the samples of all frames together lie over the view."""

    seen: NDArray[np.float32]
    """(H, W), the number of frames that show tissue there."""

    @classmethod
    def of(cls, frames: Iterable[Frame]) -> Density:
        """Of frames of one size."""
        return cls(sum(frame.tissue_mask.astype(np.float32) for frame in frames))  # type: ignore[arg-type]

    def weights(self, tissue: BoolImage) -> NDArray[np.float32]:
        """(H, W) relative frequency of a sample in a pixel of a frame; 0 where it shows no tissue."""
        often = self.seen.sum() / np.count_nonzero(self.seen)
        rarity = often / np.maximum(self.seen, np.float32(1))
        return np.asarray(tissue * ((1 - EVENNESS) + EVENNESS * rarity), np.float32)

    @property
    def of_all(self) -> NDArray[np.float32]:
        """(H, W) share of all samples in a pixel; its sum is 1."""
        total = self.seen * self.weights(self.seen > 0)
        return np.asarray(total / total.sum(), np.float32)


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
    frame: Frame, share: int, density: Density, rng: np.random.Generator
) -> tuple[Float32Array, Float32Array, Float32Array, Float32Array]:
    """World positions (S, 3), size of a pixel at their depth (S,), colours (S, 3) and the share that their
    pixel has of all samples (S,); S <= share."""
    assert frame.depth is not None
    measured = frame.depth_mask
    lowest, highest = np.percentile(frame.depth[measured], (LOWEST_PERCENTILE, HIGHEST_PERCENTILE))
    measured = measured & (frame.depth >= lowest) & (frame.depth <= highest)
    depth = filled_depth(frame.depth, measured)
    candidates = np.flatnonzero(frame.tissue_mask)
    weights = density.weights(frame.tissue_mask).reshape(-1)[candidates].astype(np.float64)
    count = min(share, len(candidates))
    chosen = rng.choice(candidates, count, replace=False, p=weights / weights.sum())
    points = frame.camera.unproject(depth).reshape(-1, 3)[chosen]
    colors = frame.image.reshape(-1, 3)[chosen] / np.float32(255)
    pixel_sizes = depth.reshape(-1)[chosen] / np.float32(frame.camera.fx)
    return points.astype(np.float32), pixel_sizes, colors, density.of_all.reshape(-1)[chosen]
