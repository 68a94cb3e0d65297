"""Error against run time of reconstruction: finished runs, measured on frames that they have not seen."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from renderer.camera import FloatArray
from renderer.clip import ByteImage, Clip, Frame
from renderer.gaussians import DynamicGaussians
from renderer.measuring.closeness import Closeness, closeness
from renderer.measuring.tissue_seen import highlights, is_seldom, recorded, shares_seen, specks
from renderer.metrics import depth_rmse, psnr_masked
from renderer.near_plane import near_plane
from renderer.paint import painted
from renderer.phantom import Phantom, View
from renderer.rasterize.cpu import render
from renderer.rasterize.rendered import Rendered, rounded
from renderer.splats import RenderMode
from renderer.train.config import TrainConfig
from renderer.train.events import Finished
from renderer.train.trainer import split
from renderer.unobserved import BLACK, GREY, Rgb

OPAQUE: Final = 0.5
"""Alpha from which the motion of a pixel is compared."""


@dataclass(frozen=True, kw_only=True)
class Quality(Closeness):
    """Means over frames; NaN where none can tell."""

    specks: float
    """Pixels a frame, see `tissue_seen.specks`; NaN where the camera moves."""
    depth_rmse: float
    """In the clip's unit; NaN without depth."""


@dataclass(frozen=True, kw_only=True)
class Outcome(Quality):
    """One run. Figures are means over the frames that it is measured on."""

    motion_rmse: float
    """Of the way from a frame to half a clip later, in the clip's unit; NaN where the truth is not known."""
    psnr_behind_tools: float
    """dB, over what tools hide in a frame and others show; NaN where the truth is not known."""
    seconds: float
    """Of training steps; reading frames, initialisation and compilation excluded."""
    megabytes: float
    """Of the model's numbers with their two moments."""
    n_gaussians: int
    iterations: int
    wall_seconds: float = math.nan
    """Of all that the run took, see `Finished`; NaN: not recorded."""


def outcome(finished: Finished, clip: Clip, config: TrainConfig, truth: Phantom | None = None) -> Outcome:
    """Of a run of `config` on `clip`: on held-out training frames where `config.hold_out` is set, else on
    test frames; on training frames where the clip is too short for any of them.

    Args:
        truth: the phantom that the clip shows, so that motion can be measured.
    """
    fit, held_out = split(clip, config)
    model, indices = finished.model, (held_out if config.hold_out else clip.test_indices) or fit
    return Outcome(
        **vars(measured(model, clip, indices, fit, config.render_mode)),
        motion_rmse=motion_rmse(model, truth, indices, config.render_mode) if truth else math.nan,
        psnr_behind_tools=behind_tools(model, truth, indices, fit, config.render_mode) if truth else math.nan,
        seconds=finished.seconds,
        megabytes=3 * model.n_bytes / 1e6,
        n_gaussians=len(model),
        iterations=finished.iteration,
        wall_seconds=math.nan if finished.wall_seconds is None else finished.wall_seconds,
    )


def measured(
    model: DynamicGaussians,
    clip: Clip,
    indices: Sequence[int],
    fit: Sequence[int],
    mode: RenderMode = "default",
) -> Quality:
    """On the frames `indices`, of a model that was trained on the frames `fit`."""
    shares = shares_seen(clip, fit)
    seldom = None if shares is None else is_seldom(shares)
    bright = highlights(clip, [*fit, *indices])
    rows = []
    for index in indices:
        frame = clip.read_frame(index)
        drawn = _drawn(model, frame, mode)
        picture = _rounded(drawn)
        mask = frame.evaluation_mask
        over_grey = _rounded(drawn, GREY)
        shown = bright | recorded(over_grey, frame)
        others = (clip.read_frame(place) for place in fit)
        known = frame.measured_depth
        depth = np.zeros_like(drawn.depth) if known is None else known
        rows.append(
            {
                **vars(closeness(picture, drawn.alpha, frame, seldom)),
                "specks": np.nan
                if shares is None
                else specks(over_grey, drawn.alpha, shares > 0, shown, others),
                "depth_rmse": depth_rmse(drawn.depth, depth, mask),
            }
        )
    return Quality(**{name: _mean([row[name] for row in rows]) for name in rows[0]})


def behind_tools(
    model: DynamicGaussians,
    truth: Phantom,
    indices: Sequence[int],
    fit: Sequence[int],
    mode: RenderMode,
) -> float:
    """PSNR in dB against the same scene without tools, where some frame of `fit` shows the tissue that they
    hide in a frame, wherever it has moved; NaN where there is none."""
    bare, views = Phantom(replace(truth.params, tools=0)), [truth.view(index) for index in fit]
    found = []
    for index in indices:
        frame, without = truth.view(index).frame, bare.view(index)
        hidden = ~frame.tissue_mask
        hidden[hidden] = np.any([_shows(view, truth, without.material[hidden]) for view in views], axis=0)
        image = without.frame.image / 255
        found.append(psnr_masked(_rounded(_drawn(model, frame, mode)) / 255, image, hidden))
    return _mean(found)


def _shows(view: View, truth: Phantom, material: FloatArray) -> NDArray[np.bool_]:
    """(N,) whether a view shows points (N, 2) of the tissue."""
    camera = view.frame.camera
    places, _, _ = truth.surface.evaluate(material[:, 0], material[:, 1], view.frame.time)
    columns, rows = np.floor(camera.project(places)[0]).astype(np.int64).T
    shown: NDArray[np.bool_] = (
        (columns >= 0) & (columns < camera.width) & (rows >= 0) & (rows < camera.height)
    )
    shown[shown] = view.frame.tissue_mask[rows[shown], columns[shown]]
    return shown


def _drawn(model: DynamicGaussians, frame: Frame, mode: RenderMode) -> Rendered:
    near = near_plane(model, frame.camera)
    return render(model.at(frame.time), frame.camera, near=near, mode=mode)


def _rounded(drawn: Rendered, behind: Rgb = BLACK) -> ByteImage:
    laid = drawn.image + (1 - drawn.alpha[..., None]) * np.array(behind, np.float32)
    return rounded(laid)


def _mean(values: Sequence[float]) -> float:
    """Of those that are numbers; NaN without any."""
    known = [value for value in values if not np.isnan(value)]
    return float(np.mean(known)) if known else math.nan


def motion_rmse(
    model: DynamicGaussians, truth: Phantom, indices: Sequence[int], mode: RenderMode = "default"
) -> float:
    """Root mean square over the frames' tissue pixels of the error of the way that the tissue there goes
    from the frame to the one half a clip later, in mm; the model's way is blended as its colours are."""
    errors, count = [], truth.params.n_frames
    for index in indices:
        view, later = truth.view(index), (index + count // 2) % count / count
        now, then = model.at(view.frame.time), model.at(later)
        ways, near = painted(now, then.means - now.means), near_plane(model, view.frame.camera)
        drawn = render(ways, view.frame.camera, near=near, mode=mode)
        seen = view.frame.evaluation_mask & (drawn.alpha > OPAQUE)
        u, v = view.material[seen].T
        began, _, _ = truth.surface.evaluate(u, v, view.frame.time)
        ended, _, _ = truth.surface.evaluate(u, v, later)
        way = drawn.image[seen] / drawn.alpha[seen, None]
        errors.append(np.mean(np.sum((way - (ended - began)) ** 2, axis=1)))
    return float(np.sqrt(np.mean(errors)))
