"""Gains of frames, some of them broken, against normal equations in float64 and the true ones."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final

import cv2
import numpy as np

from renderer.camera import Camera, FloatArray
from renderer.clip import Frame
from renderer.frame_gains import APART, BRIGHTEST, CLIPPED, DARKEST, LEAST, REST, log_gains
from renderer.measuring.stability.row import Row, worst

HAZARD: Final = "gains of frames"
EXACT: Final = 2e-6
"""What float32 loses of a logarithm."""
CLOSE: Final = 0.003
"""From the true gains, but for what drifts: grey levels are whole numbers."""
WIDTH, HEIGHT, BROKEN = 64, 48, 5
PUMPING: Final = (1.0, 1.1, 0.92, 1.04, 0.9, 1.08, 0.97, 1.1, 0.93, 1.0, 1.06, 0.9, 1.05, 0.95)
TINT: Final = np.array([1.7, 1.0, 0.8])
"""Of tissue: red is cut off first."""
LEFT: Final = "has no gain"


def _surface(seed: int = 0) -> FloatArray:
    """(H, W, 3) grey levels of smooth tissue."""
    rough = np.random.default_rng(seed).uniform(-1, 1, (HEIGHT, WIDTH))
    smooth = cv2.GaussianBlur(rough, (0, 0), 3)
    levels = 100 + 40 * smooth / np.abs(smooth).max()
    return np.asarray(levels[..., None] * TINT)


def _frame(levels: FloatArray, index: int, tissue: bool = True) -> Frame:
    mask = np.full((HEIGHT, WIDTH), tissue)
    image = np.clip(np.rint(levels), 0, 255).astype(np.uint8)
    return Frame(index, index / len(PUMPING), image, Camera.from_fov(60, WIDTH, HEIGHT), mask, mask)


def _with(broken: Callable[[FloatArray], FloatArray], tissue: bool = True) -> list[Frame]:
    """A clip that pumps, one of whose frames is another."""
    frames = [_frame(gain * _surface(), index) for index, gain in enumerate(PUMPING)]
    frames[BROKEN] = _frame(broken(_surface()), BROKEN, tissue)
    return frames


BROKEN_BY: Final[dict[str, Callable[[], list[Frame]]]] = {
    "a black frame": lambda: _with(lambda levels: 0 * levels),
    "a frame that is clipped all over": lambda: _with(lambda levels: 1e9 * levels),
    "a gain of 4": lambda: _with(lambda levels: 4 * levels),
    "a frame without tissue": lambda: _with(lambda levels: levels, tissue=False),
}
ALL: Final[dict[str, Callable[[], list[Frame]]]] = BROKEN_BY | {
    "a gain of 1.6": lambda: _with(lambda levels: 1.6 * levels),
    "no frame shows tissue": lambda: [_frame(_surface(), index, tissue=False) for index in range(9)],
    "other tissue in every frame": lambda: [_frame(_surface(index), index) for index in range(9)],
    "one frame": lambda: [_frame(_surface(), 0)],
    "500 frames": lambda: [_frame(PUMPING[at % 5] * _surface(), at) for at in range(500)],
}


def rows() -> Iterator[Row]:
    for case, frames in ALL.items():
        errors = np.abs(log_gains(frames()) - _exact(frames()))
        yield Row(HAZARD, f"{case}, normal equations", worst(errors), EXACT, "log gain")
    for case, frames in BROKEN_BY.items():
        found = log_gains(frames())
        errors = np.delete(found - np.log(PUMPING), BROKEN)
        wild = 0.0 if abs(found[BROKEN]) < 0.1 else np.inf
        measured = max(float(np.std(errors)), wild)
        yield Row(HAZARD, f"{case}, true gains of the others", measured, CLOSE, "log gain", LEFT)


def _exact(frames: list[Frame]) -> FloatArray:
    """As they are defined, of frames of one small size."""
    logs = [_logs(frame) for frame in frames]
    matrix, right = REST**2 * np.eye(len(frames)), np.zeros(len(frames))
    for one in range(len(frames)):
        for other in (one + apart for apart in APART if one + apart < len(frames)):
            differences = logs[other] - logs[one]
            known = differences[~np.isnan(differences)]
            if len(known) < LEAST:
                continue
            pair = np.zeros(len(frames))
            pair[one], pair[other] = -1, 1
            matrix += np.outer(pair, pair)
            right += np.median(known) * pair
    return np.asarray(np.linalg.solve(matrix, right), np.float64)


def _logs(frame: Frame) -> FloatArray:
    """(H, W) logarithm of grey; NaN where it is not compared."""
    grey = cv2.cvtColor(frame.image, cv2.COLOR_RGB2GRAY).astype(np.float64)
    known = frame.tissue_mask & (frame.image < CLIPPED).all(axis=2) & (grey >= DARKEST) & (grey <= BRIGHTEST)
    return np.where(known, np.log(np.maximum(grey, 1)), np.nan)
