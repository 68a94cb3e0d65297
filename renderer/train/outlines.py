"""Tissue beside tools whose masks end at the tools' outline: it is in part of their colour.

Optics blur, and a pixel gathers what lies in it: where a mask ends just where the tool does, pixels beside it
are a mixture, and what is trained on them leaves a grey outline of the tool on the tissue behind. Masks that
people draw, and those that the program finds, reach beyond the tool: beside them is nothing but tissue.

Which of both they are, the images tell: across the edge of a tight mask colour steps as from steel to
tissue, across that of a wide one no more than it does from tissue to tissue.

Training frames of the phantom of the demo (600 steps, 12000 Gaussians, seed 0), behind its tools: 18.7 dB
without, 20.8 where what some frame shows stays opaque behind tools (`TrainFrame.opaque`), 23.4 with both.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.clip import BoolImage, Frame
from renderer.evenly import evenly
from renderer.train.events import Omission
from renderer.train.frame_store import FrameStore
from renderer.train.frames import away_from_tools

MIXED: Final = 2.0
"""Pixels beside a tool that are in part of its colour."""
BANDS: Final = ((-5.0, -2.0), (2.0, 5.0), (6.0, 9.0))
"""Pixels from the edge of a mask, within it and beyond, whose colours are compared."""
BLUR: Final = 3.0
"""Standard deviation in pixels over which they are averaged."""
LEAST: Final = np.float32(2e-4)
"""Of a band, about a pixel of the edge, to have a colour there."""
TIGHT: Final = 4.0
"""Times the step of colour from tissue to tissue by which it steps at the outline of a tool. Medians of
training frames: phantom 7.5, pulling 1.8 and mesentery 1.7."""
MOST: Final = 16
"""Frames that are looked at."""


def without_outlines(frames: FrameStore[Frame], apart: BoolImage, folder: Path | None) -> FrameStore[Frame]:
    """The frames, of one camera that does not move, without tissue that is MIXED with tools where some frame
    shows it `apart` from them (H, W). They are taken from their store."""
    return FrameStore.of((without_mixed(frames.take(place), apart) for place in range(len(frames))), folder)


def told(frames: Sequence[Frame], apart: BoolImage) -> Iterator[Omission]:
    """What that leaves out, if anything: beside what no frame uncovers, as a dark surround, all is kept."""
    before = sum(np.count_nonzero(frame.tissue_mask) for frame in frames)
    kept = sum(np.count_nonzero(without_mixed(frame, apart).tissue_mask) for frame in frames)
    if kept < before:
        saves = f"{100 * (1 - kept / before):.1f} % of the tissue"
        yield Omission("tissue beside tools", "it has part of their colour", saves, "beside_tools")


def are_tight(frames: Sequence[Frame]) -> bool:
    """Whether colour steps where their masks end."""
    steps = [_steps(frames[place]) for place in evenly(range(len(frames)), MOST)]
    across, beside = np.median(np.concatenate(steps), axis=0) if sum(map(len, steps)) else (0.0, 0.0)
    return bool(across > TIGHT * beside)


def seen_apart(frames: Sequence[Frame]) -> BoolImage:
    """(H, W) where some of the frames, of one camera that stays, shows tissue that is not MIXED."""
    apart = np.zeros(frames[0].tissue_mask.shape, bool)
    for frame in frames:
        apart |= away_from_tools(frame.tissue_mask) > MIXED
    return apart


def without_mixed(frame: Frame, apart: BoolImage) -> Frame:
    """The frame without tissue that is MIXED with a tool, where some frame shows it `apart` (H, W)."""
    kept = (away_from_tools(frame.tissue_mask) > MIXED) | ~apart
    return replace(frame, tissue_mask=frame.tissue_mask & kept)


def _steps(frame: Frame) -> NDArray[np.float32]:
    """(n, 2) at n pixels along the edges of its mask: how far colours are apart across it, and beyond it."""
    if frame.tissue_mask.all():
        return np.empty((0, 2), np.float32)
    outside = away_from_tools(frame.tissue_mask)
    signed = outside - away_from_tools(~frame.tissue_mask)
    edge, colors = (outside > 0) & (outside <= 1), []
    for least, most in BANDS:
        band = ((signed > least) & (signed <= most)).astype(np.float32)
        share = cv2.GaussianBlur(band, (0, 0), BLUR)
        total = cv2.GaussianBlur(frame.image * band[..., None], (0, 0), BLUR)
        edge &= share > LEAST
        colors.append(total / np.maximum(share, LEAST)[..., None])
    inside, near, far = (color[edge] for color in colors)
    return np.stack([np.linalg.norm(near - inside, axis=1), np.linalg.norm(far - near, axis=1)], axis=1)
