"""Gaussians from the measured depth of the training frames."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.camera import FloatArray
from renderer.clip import BoolImage, Clip, ClipError, Frame, SparsePoints
from renderer.depth.filled_depth import filled_depth
from renderer.depth.sparse_depth import depth_between
from renderer.raw_gaussians import RawGaussians
from renderer.splats import Float32Array
from renderer.train.config import TrainConfig

MOST_DISTANT = 1e9
"""Depth in the clip's unit; the reciprocal is the least."""
RESOLVED = 0.5
"""Of a pixel on the tissue, by which float32 may round a position."""
# Depth at both ends of a frame's range is stereo error more often than tissue.
LOWEST_PERCENTILE, HIGHEST_PERCENTILE = 0.1, 99.9
EVENNESS = 0.5
"""Share of the samples that are spread evenly over all pixels that any frame shows."""
DETAIL = 0.7
"""Share of the density, in our own methods, that goes with the detail there. Chosen on frames held out of
training (1000 steps, seed 0) among 0, 0.3, 0.5, 0.7, 0.8 and 1: pulling 37.51, 37.67, 37.74, 37.80, 37.73 and
37.85 dB; mesentery 34.87 for 0, 35.29, 35.24 and 35.33 for 0.5 to 0.8; a phantom that is alike all over 36.8
to 37.0. Blurs of 1.5 and 6 px are as good as that of 3. After 3000 steps of pulling, 38.66 for 38.46 dB."""
HALVINGS = 40
"""Of an interval, until float32 holds no better."""
BLUR = 3.0
"""Standard deviation in pixels over which detail is averaged."""
MOST_DETAIL = 98.0
"""Percentile that stands for more: highlights and edges of the mask are no finer tissue."""


class NoTissue(ClipError):
    """No frame has depth on tissue."""


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
        NoTissue: no frame has depth on tissue.
        ClipError: that is no length that can be calculated with.
    """
    medians, is_masked = list[float](), False
    for frame in frames:
        if (median := frame.median_depth) is not None:
            medians.append(median)
        else:
            # Readers may leave no depth where they leave no tissue.
            left_out = not frame.tissue_mask.any()
            is_masked |= frame.depth is not None and (left_out or bool((frame.depth > 0).any()))
    if not medians:
        got = "its masks leave out all of it" if is_masked else "this clip has none"
        raise NoTissue(f"reconstruction expects measured depth on the tissue, and {got}")
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


AtRest = Callable[[FloatArray, float], Float32Array]
"""Of world positions (N, 3) that are seen at a time, where they rest (N, 3)."""


def sampled(
    frames: Sequence[Frame], config: TrainConfig, detail: float = 0.0, at_rest: AtRest | None = None
) -> RawGaussians:
    """Random tissue pixels of the given frames, placed behind the centre of their pixel.

    Half of the Gaussians are spread over the frames, so that what is often seen, and often judged, has the
    more of them; half over all pixels that any frame shows, so that what is seldom seen has no gaps. Both
    lie denser where there is more detail, to the share `detail` in [0, 1]. A Gaussian's size follows from the
    spacing that the samples have about its pixel.

    Where a frame has no depth on tissue, the depth around it places them (`filled_depth`). `at_rest` takes
    them from there to where they rest.
    """
    rng = np.random.default_rng(config.seed)
    # The frames themselves may be more than memory holds.
    measured = [place for place in range(len(frames)) if frames[place].depth_mask.any()]
    density = Density.of((frames[place] for place in measured), detail)
    totals = np.array([density.weights(frames[place].tissue_mask).sum() for place in measured])
    ends = np.rint(np.cumsum(totals) / totals.sum() * config.n_gaussians).astype(int)
    shares = np.diff(ends, prepend=0)
    parts = [
        _sample(frames[place], int(share), density, rng, at_rest)
        for place, share in zip(measured, shares, strict=True)
    ]
    means, pixel_sizes, colors, pixels = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    spacing = pixel_sizes / np.sqrt(density.expected(len(means)).reshape(-1)[pixels])
    return round_gaussians(means, config.initial_spacing * spacing, colors, config.initial_opacity)


@dataclass(frozen=True, eq=False)
class Density:
    """How the samples of all frames together lie over the view."""

    seen: Float32Array
    """(H, W), the number of frames that show tissue there."""
    detail: Float32Array
    """(H, W), how much denser than elsewhere they lie there, by the frames that show it; about 1."""

    @classmethod
    def of(cls, frames: Iterable[Frame], share: float) -> Density:
        """Of frames of one size."""
        both = sum(
            np.stack([frame.tissue_mask, frame.tissue_mask * relative_detail(frame, share)])
            for frame in frames
        )
        seen, detail = np.asarray(both, np.float32)
        return cls(seen, detail / np.maximum(seen, np.float32(1)))

    def weights(self, tissue: BoolImage) -> Float32Array:
        """(H, W) relative frequency of a sample in a pixel of a frame; 0 where it shows no tissue."""
        often = self.seen.sum() / np.count_nonzero(self.seen)
        rarity = often / np.maximum(self.seen, np.float32(1))
        return np.asarray(tissue * self.detail * ((1 - EVENNESS) + EVENNESS * rarity), np.float32)

    def expected(self, count: int) -> Float32Array:
        """(H, W) how many of `count` samples fall into a pixel, of which a frame gives one at most."""
        wanted = (self.seen * self.weights(self.seen > 0)).astype(np.float64)
        low, high = 0.0, float(self.seen.max() / wanted[wanted > 0].min())
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            too_many = np.minimum(middle * wanted, self.seen).sum() > count
            low, high = (low, middle) if too_many else (middle, high)
        return np.minimum(high * wanted, self.seen).astype(np.float32)


def relative_detail(frame: Frame, share: float) -> Float32Array:
    """(H, W) 1 - share, and share times the mean slope of the brightness about a pixel over that of all
    tissue; the border of the mask has no part in it."""
    if share == 0 or not frame.tissue_mask.any():
        return np.ones(frame.tissue_mask.shape, np.float32)
    grey = cv2.cvtColor(frame.image, cv2.COLOR_RGB2GRAY).astype(np.float32)
    inner = cv2.erode(frame.tissue_mask.astype(np.uint8), np.ones((5, 5), np.uint8)).astype(np.float32)
    across, down = cv2.Sobel(grey, cv2.CV_32F, 1, 0), cv2.Sobel(grey, cv2.CV_32F, 0, 1)
    slope = np.sqrt(across * across + down * down)  # cv2.magnitude depends on where its arrays lie in memory.
    inside = cv2.GaussianBlur(inner, (0, 0), BLUR)
    around = cv2.GaussianBlur(slope * inner, (0, 0), BLUR) / np.maximum(inside, np.float32(1e-3))
    around = np.minimum(around, np.percentile(around[frame.tissue_mask], MOST_DETAIL)).astype(np.float32)
    mean = float(around[frame.tissue_mask].mean(dtype=np.float64))
    relative = around / np.float32(mean) if mean > 0 else np.ones_like(grey)
    return np.asarray((1 - share) + share * relative, np.float32)


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


def _sample(
    frame: Frame, share: int, density: Density, rng: np.random.Generator, at_rest: AtRest | None
) -> tuple[Float32Array, Float32Array, Float32Array, NDArray[np.int64]]:
    """World positions (S, 3), size of a pixel at their depth (S,), colours (S, 3) and their pixels (S,) in
    row order; S <= share."""
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
    resting = points.astype(np.float32) if at_rest is None else at_rest(points, frame.time)
    return resting, pixel_sizes, colors, chosen
