"""The brightness of each frame against the clip's common exposure: of a camera whose automatic exposure or
lamp does not come to rest.

One gain a frame, found before training from the same tissue in frames close to each other, in closed form.
It multiplies values as they are coded: a gain of the light to the power of one over the camera's gamma.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.camera import FloatArray
from renderer.clip import BoolImage, ByteImage, Clip, Frame

LONGEST_SIDE = 160
"""Pixels of the frames that are compared: so small, tissue hardly moves from one frame to the next."""
DARKEST, BRIGHTEST = 16, 245
"""Grey levels that are compared: noise tells of darker ones, brighter ones may be cut off."""
CLIPPED = 255
LEAST = 100
"""Pixels that a ratio is the median of, at least."""
APART = (1, 2, 4)
"""Places in the order of time between frames that are compared."""
REST = 0.2
"""Pull of a gain to 1, against a ratio: what takes more than about 140 frames is left to the light on tissue
that comes and goes. On held-out training frames of a phantom with a moving camera 0.15 dB better than 0.05,
and the same with a fixed one (400 steps, pumping by 5 %)."""
OVER = 5
"""Frames whose mean the curves of colours follow."""


@dataclass(frozen=True, eq=False)
class Brightness:
    """What a frame is compared by."""

    values: NDArray[np.float32]
    """(h, w) mean grey level of the pixels that can be compared."""
    known: BoolImage
    """(h, w) all of them can be: lit tissue without highlights."""


def brightness(frame: Frame) -> Brightness:
    """Of the frame at a small size."""
    height, width = frame.tissue_mask.shape
    factor = max(1.0, max(height, width) / LONGEST_SIDE)
    size = max(1, round(width / factor)), max(1, round(height / factor))
    whole = frame.tissue_mask & (frame.image.max(axis=2) < CLIPPED)
    counted = whole.astype(np.float32)
    grey = cv2.cvtColor(frame.image, cv2.COLOR_RGB2GRAY) * counted
    values = np.asarray(cv2.resize(grey, size, interpolation=cv2.INTER_AREA), np.float32)
    known = cv2.resize(counted, size, interpolation=cv2.INTER_AREA) > 0.999
    return Brightness(values, known & (values >= DARKEST) & (values <= BRIGHTEST))


def log_ratio(one: Brightness, other: Brightness) -> float | None:
    """Natural logarithm of how much brighter the other one is: the median over what both show at the same
    place. None where that is too little, as of a black frame or one of another size."""
    if one.known.shape != other.known.shape:
        return None
    both = one.known & other.known
    if np.count_nonzero(both) < LEAST:
        return None
    return float(np.median(np.log(other.values[both] / one.values[both])))


def log_gains(frames: Iterable[Frame]) -> FloatArray:
    """Natural logarithms (N,) of the gains of frames in the order of time; 0 of one that nothing is known of.

    Least squares over the ratios of all pairs that are compared, each gain with a weak pull to 1.
    """
    before = deque[Brightness](maxlen=max(APART))
    pairs, ratios = list[tuple[int, int]](), list[float]()
    count = 0
    for place, frame in enumerate(frames):
        now = brightness(frame)
        for apart in APART:
            if apart > len(before):
                continue
            ratio = log_ratio(before[-apart], now)
            if ratio is not None:
                pairs.append((place - apart, place))
                ratios.append(ratio)
        before.append(now)
        count = place + 1
    first, second = np.array(pairs, np.int64).reshape(-1, 2).T
    return _least_squares(count, first, second, np.array(ratios))


def _least_squares(
    count: int, first: NDArray[np.int64], second: NDArray[np.int64], ratios: FloatArray
) -> FloatArray:
    """x (count,) of least sum (x[second] - x[first] - ratios)^2 + REST^2 x^2, by conjugate gradients."""

    def gathered(differences: FloatArray) -> FloatArray:
        return np.asarray(
            np.bincount(second, differences, count) - np.bincount(first, differences, count), np.float64
        )

    found = np.zeros(count)
    residual = gathered(ratios)
    step, size = residual.copy(), float(residual @ residual)
    least = 1e-20 * size
    for _ in range(20 * count):
        if size <= least:
            break
        applied = gathered(step[second] - step[first]) + REST**2 * step
        share = size / float(step @ applied)
        found += share * step
        residual -= share * applied
        before, size = size, float(residual @ residual)
        step = residual + size / before * step
    return found


def log_gain_beside(frame: Frame, others: Sequence[tuple[Frame, float]]) -> float:
    """Natural logarithm of the gain of a frame from that of others before and after it, which it does not
    change: the mean of what they say; 0 where none can be compared."""
    own = brightness(frame)
    ratios = [(log_ratio(brightness(other), own), gain) for other, gain in others]
    told = [ratio + gain for ratio, gain in ratios if ratio is not None]
    return float(np.mean(told)) if told else 0.0


def jitter(gains: FloatArray) -> float:
    """Root mean square of what logarithms of gains (N,) differ by from their means over OVER frames, which
    the colours of a model could follow: 0.01 is a percent from frame to frame. 0 of fewer frames."""
    if len(gains) < OVER:
        return 0.0
    means = np.convolve(gains, np.full(OVER, 1 / OVER), "valid")
    return float(np.sqrt(np.mean((gains[OVER // 2 : len(gains) - OVER // 2] - means) ** 2)))


def exposed(image: ByteImage, gain: float) -> ByteImage:
    """The image (H, W, 3) times a gain; what is cut off at the brightest level stays there."""
    if gain == 1:
        return image
    levels = np.arange(256)
    table = np.where(levels == CLIPPED, CLIPPED, np.clip(np.rint(levels * gain), 0, CLIPPED))
    return np.asarray(cv2.LUT(image, table.astype(np.uint8)))


def steadied(frame: Frame) -> Frame:
    """The frame in the clip's common exposure."""
    if frame.gain == 1:
        return frame
    return replace(frame, image=exposed(frame.image, 1 / frame.gain), gain=1.0)


def with_gains(clip: Clip, gains: Sequence[float]) -> Clip:
    """The clip whose frames know their gains, one a frame. Raises ValueError: another number of them."""
    if len(gains) != len(clip):
        raise ValueError(f"expected {len(clip)} gains, one a frame, got {len(gains)}")

    def read_frame(index: int) -> Frame:
        frame = clip.read_frame(index)
        return replace(frame, gain=gains[frame.index])

    return replace(clip, read_frame=read_frame)
