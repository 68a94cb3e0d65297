"""Error against run time of reconstruction: whole runs, measured on frames that they have not seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from renderer.clip import Clip
from renderer.gaussians import DynamicGaussians
from renderer.metrics import depth_rmse, psnr, psnr_masked, ssim
from renderer.near_plane import near_plane
from renderer.rasterize.cpu import render
from renderer.train.config import TrainConfig
from renderer.train.events import Finished
from renderer.train.trainer import split, train


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """One run. Figures are means over the frames that it is measured on."""

    psnr: float
    """dB, masked, over all pixels, 8-bit rounded."""
    psnr_masked: float
    """dB, over the evaluated pixels."""
    ssim: float
    depth_rmse: float
    """In the clip's unit; NaN without depth."""
    seconds: float
    """Of training steps; reading frames, initialisation and compilation excluded."""
    n_gaussians: int
    iterations: int


def outcome(clip: Clip, config: TrainConfig) -> Outcome:
    """Train and measure: on held-out training frames where `config.hold_out` is set, else on test frames.

    Raises:
        ClipError, TrainingError: as `train`.
    """
    finished = next(event for event in train(clip, config) if isinstance(event, Finished))
    _, held_out = split(clip, config)
    figures = measured(finished.model, clip, held_out if config.hold_out else clip.test_indices)
    return Outcome(
        psnr=figures[0],
        psnr_masked=figures[1],
        ssim=figures[2],
        depth_rmse=figures[3],
        seconds=finished.seconds,
        n_gaussians=len(finished.model),
        iterations=finished.iteration,
    )


def measured(
    model: DynamicGaussians, clip: Clip, indices: Sequence[int]
) -> tuple[float, float, float, float]:
    """Mean psnr, psnr_masked, ssim and depth_rmse over the frames."""
    rows = []
    for index in indices:
        frame = clip.read_frame(index)
        drawn = render(model.at(frame.time), frame.camera, near=near_plane(model, frame.camera))
        picture = np.rint(np.clip(drawn.image, 0, 1) * 255) / 255
        photo, mask = frame.image / 255.0, frame.evaluation_mask
        known = frame.measured_depth
        depth = np.zeros_like(drawn.depth) if known is None else known
        rows.append(
            (
                psnr(picture, photo, mask),
                psnr_masked(picture, photo, mask),
                ssim(picture, photo, mask),
                depth_rmse(drawn.depth, depth, mask),
            )
        )
    means = np.mean(rows, axis=0)
    return float(means[0]), float(means[1]), float(means[2]), float(means[3])
