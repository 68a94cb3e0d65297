"""Error against run time of reconstruction: finished runs, measured on frames that they have not seen."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, get_args

import numpy as np

from renderer.clip import Clip
from renderer.gaussians import DynamicGaussians
from renderer.metrics import depth_rmse, psnr, psnr_masked, ssim
from renderer.near_plane import near_plane
from renderer.phantom import Phantom
from renderer.rasterize.cpu import render
from renderer.splats import RenderMode
from renderer.train.config import Method, TrainConfig
from renderer.train.events import Finished
from renderer.train.trainer import split

OPAQUE: Final = 0.5
"""Alpha from which the motion of a pixel is compared."""
KNOBS: Final[dict[str, tuple[dict[str, Any], ...]]] = {
    "method": tuple({"method": name} for name in get_args(Method)),
    "iterations": (
        *({"iterations": count} for count in (250, 500, 1000, 2000, 6000)),
        *({"method": "deform3dgs", "iterations": count} for count in (500, 1000, 2000)),
        *({"method": "endogaussian", "iterations": count} for count in (500, 1000)),
        *({"method": "static", "iterations": count} for count in (250, 1000)),
    ),
    "n_gaussians": tuple({"n_gaussians": count} for count in (7500, 15_000, 60_000)),
    "n_controls": tuple({"n_controls": count} for count in (4, 8, 32)),
    "half_resolution_share": tuple({"half_resolution_share": share} for share in (0.0, 2 / 3)),
}
"""What is turned, and what it is turned to; all else is the default."""


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
    motion_rmse: float
    """Of the way from a frame to half a clip later, in the clip's unit; NaN where the truth is not known."""
    seconds: float
    """Of training steps; reading frames, initialisation and compilation excluded."""
    megabytes: float
    """Of the model's numbers with their two moments."""
    n_gaussians: int
    iterations: int
    wall_seconds: float = float("nan")
    """Of all that the run took, see `Finished`; NaN: not recorded."""


def settings() -> Iterator[tuple[str, TrainConfig]]:
    """Every knob with each of its settings; the first is the default."""
    for knob, changes in KNOBS.items():
        for change in changes:
            yield knob, replace(TrainConfig(), **change)


def outcome(finished: Finished, clip: Clip, config: TrainConfig, truth: Phantom | None = None) -> Outcome:
    """Of a run of `config` on `clip`: on held-out training frames where `config.hold_out` is set, else on
    test frames.

    Args:
        truth: the phantom that the clip shows, so that motion can be measured.
    """
    model, indices = finished.model, split(clip, config)[1] if config.hold_out else clip.test_indices
    image, masked, likeness, depth = measured(model, clip, indices, config.render_mode)
    return Outcome(
        psnr=image,
        psnr_masked=masked,
        ssim=likeness,
        depth_rmse=depth,
        motion_rmse=motion_rmse(model, truth, indices, config.render_mode) if truth else float("nan"),
        seconds=finished.seconds,
        megabytes=3 * sum(value.nbytes for value in model.arrays().values()) / 1e6,
        n_gaussians=len(model),
        iterations=finished.iteration,
        wall_seconds=float("nan") if finished.wall_seconds is None else finished.wall_seconds,
    )


def measured(
    model: DynamicGaussians, clip: Clip, indices: Sequence[int], mode: RenderMode = "default"
) -> tuple[float, float, float, float]:
    """Mean psnr, psnr_masked, ssim and depth_rmse over the frames."""
    rows = []
    for index in indices:
        frame = clip.read_frame(index)
        near = near_plane(model, frame.camera)
        drawn = render(model.at(frame.time), frame.camera, near=near, mode=mode)
        picture = np.rint(np.clip(drawn.image, 0, 1) * 255) / 255
        image, mask = frame.image / 255.0, frame.evaluation_mask
        known = frame.measured_depth
        depth = np.zeros_like(drawn.depth) if known is None else known
        rows.append(
            (
                psnr(picture, image, mask),
                psnr_masked(picture, image, mask),
                ssim(picture, image, mask),
                depth_rmse(drawn.depth, depth, mask),
            )
        )
    means = np.mean(rows, axis=0)
    return float(means[0]), float(means[1]), float(means[2]), float(means[3])


def motion_rmse(
    model: DynamicGaussians, truth: Phantom, indices: Sequence[int], mode: RenderMode = "default"
) -> float:
    """Root mean square over the frames' tissue pixels of the error of the way that the tissue there goes
    from the frame to the one half a clip later, in mm; the model's way is blended as its colours are."""
    errors, count = [], truth.params.n_frames
    for index in indices:
        view, later = truth.view(index), (index + count // 2) % count / count
        now, then = model.at(view.frame.time), model.at(later)
        ways = replace(now, colors=then.means - now.means, harmonics=now.harmonics[:, :0])
        near = near_plane(model, view.frame.camera)
        drawn = render(ways, view.frame.camera, near=near, mode=mode)
        seen = view.frame.evaluation_mask & (drawn.alpha > OPAQUE)
        u, v = view.material[seen].T
        began, _, _ = truth.surface.evaluate(u, v, view.frame.time)
        ended, _, _ = truth.surface.evaluate(u, v, later)
        way = drawn.image[seen] / drawn.alpha[seen, None]
        errors.append(np.mean(np.sum((way - (ended - began)) ** 2, axis=1)))
    return float(np.sqrt(np.mean(errors)))
