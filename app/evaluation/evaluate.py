"""A finished run measured on its held-out frames, against the frames it was trained on."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
import platformdirs
from numba import get_num_threads

from app.errors import UserError
from app.evaluation.mean import mean_of_finite
from app.files.provenance import plain
from app.runs.memory import peak_memory_mb
from app.runs.processor import load_average
from app.runs.run_edits import RecordedEdits, read_edits
from app.runs.run_folder import RunFolder, RunRecord
from app.runs.trained_clip import input_clip, run_clip
from app.runs.wall_clock import STEPS, WALL
from app.scenes.cpu_rendering import DrawOptions, draw_on_cpu
from enhance.metrics import dvbv_local, dvbv_otsu, line_scale, saturated_share, vessel_contrast
from enhance.ridges import vessel_mask
from renderer.camera import Camera
from renderer.clip import BoolImage, ByteImage, Clip, Frame, Split
from renderer.frame_gains import exposed
from renderer.gaussians import DynamicGaussians
from renderer.lpips import WEIGHT_FILES, Lpips, LpipsWeightsError, read_lpips, weight_files
from renderer.measuring.closeness import Closeness, closeness
from renderer.measuring.tissue_seen import SELDOM, seldom_seen
from renderer.metrics import OPAQUE, depth_abs_rel, depth_coverage, depth_rmse
from renderer.near_plane import near_plane
from renderer.rasterize.cpu import BLACK, Rasterizer
from renderer.rasterize.rendered import Rendered
from renderer.readers.geometry.depth_maps import OUTLIER
from renderer.splats import RenderMode
from renderer.torch_presence import NO_TORCH, has_torch
from renderer.train.config import CHOSEN
from renderer.train.methods import departures
from renderer.train.trainer import split

REPEATS = 5
"""Drawings of a frame whose time is taken."""
LPIPS_VARIABLE = "VESSELSPLAT_LPIPS"
LPIPS = "AlexNet, version 0.1, in [-1, 1], both images times the evaluation mask; lower is better"
DEFINITIONS = {
    "gains": "true: brightness pumps, and psnr, ssim and lpips show the render in the exposure of each "
    "frame, by one gain found from that frame and those beside it, not from the render",
    "psnr": "dB, both images times the evaluation mask, mean over all pixels, render rounded to 8 bits",
    "psnr_masked": "dB, mean over the evaluated pixels only: lower by -10 log10(evaluated_share)",
    "ssim": "11x11 Gaussian window of sigma 1.5, both images times the evaluation mask, zeros beyond the "
    "border, mean over all pixels and channels",
    "depth_rmse_mm": "float millimetres along z over the evaluated pixels where the clip has a depth and the "
    "render, too; depth maps are read without failed matches, which are treated as missing: values more than "
    f"{OUTLIER:g} times as far as the frame's median, or nearer than 1/{OUTLIER:g} of it; depth.abs_rel: the "
    "mean of |error| / depth there; depth.covered: their share of the evaluated pixels where the clip has a "
    "depth",
    "psnr_tissue": "dB, mean over all tissue, with measured depth or without: all but tools, burned-in text "
    "and what the clip's mask leaves out",
    "psnr_seldom": f"dB, mean over tissue in pixels where at most {100 * SELDOM:.0f} % of the training "
    "frames show any; not measured where the camera moves, or where there is none",
    "coverage": f"share of the pixels that show tissue where the render's alpha is at least {OPAQUE}",
    "dv_bv": "inferred definition: variances of grey above and below each image's own Otsu threshold, "
    "over the evaluated pixels, so that pixels under tools or never seen are left out",
    "whole_picture": "the same over every pixel of the render, black where nothing was reconstructed",
    "visibility": "beside dv_bv, over the evaluated pixels of the render: Weber contrast in green of the "
    "strongest dark ridges of the clip's own frame, the share of pixels at 250 of 255 or more, and the ratio "
    "of local variances over detail and background, with one mask from the clip's own frame; ridges are "
    "looked for and compared at widths that shrink with frames below 640 pixels",
    "ms_per_frame": f"median of {REPEATS} renderings after one warm-up, from the parameters to the "
    "image and its depth, all threads done; parts_ms: the deformation; projection and sort, as a rendering "
    "without any tile; the rest; timed_with: threads, and the machine's load average over the last minute "
    "(null: the system keeps none)",
    "peak_memory_mb": "peak resident memory of the training process (null: not logged), and of this one",
    "train_seconds": STEPS,
    "wall_seconds": WALL,
    "edits": "null: the run has no edits; else whether the edited model was measured, and "
    "how many Gaussians the edits remove",
    "mean": "mean over the frames; values not measured, infinite or undefined (null in a frame) are left "
    "out; null: none is left",
}
HELD_OUT: Final[Mapping[Split, str]] = {"field": "(index - 1) % 8 == 0", "even-odd": "those of odd index"}
"""The frames, by how a clip is split."""
Numbers = dict[str, float]


@dataclass(frozen=True, kw_only=True)
class FrameMeasures(Closeness):
    """One frame; NaN where a measure is undefined, None where it was not taken."""

    index: int
    label: str
    time: float
    evaluated_share: float
    """Of the pixels, 0 to 1."""
    lpips: float | None
    depth_rmse_mm: float | None
    """None also where the clip has no millimetres."""
    depth: Numbers | None
    """Relative error, and the share that was compared; None without depth."""
    dv: float
    bv: float
    dv_bv: float
    visibility: Numbers
    ms_per_frame: float
    parts_ms: Numbers
    whole_picture: Numbers
    """DV, BV and their ratio over every pixel of the render."""
    original_photo: Numbers
    """The same over the evaluated pixels of the clip's own frame, with its visibility."""
    input_photo: Numbers
    """And of the frame that the run was trained on."""


AVERAGED = (
    "psnr",
    "psnr_masked",
    "psnr_tissue",
    "psnr_seldom",
    "coverage",
    "ssim",
    "lpips",
    "depth_rmse_mm",
    "dv",
    "bv",
    "dv_bv",
    "ms_per_frame",
)
GROUPS = ("depth", "visibility", "parts_ms", "whole_picture", "original_photo", "input_photo")


@dataclass(frozen=True, eq=False)
class Evaluation:
    """All that is needed to measure a run."""

    run: RunFolder
    record: RunRecord
    clip: Clip
    trained_clip: Clip
    """The clip with the frames that the run was trained on."""
    model: DynamicGaussians
    lpips: Lpips | None
    """None: not measured."""
    edits: dict[str, Any] | None = None
    """Whether the edits of the run are measured, and what they leave out; None where it has none."""

    @property
    def indices(self) -> tuple[int, ...]:
        """The frames to measure: see `frames_are`."""
        return self.record.test_indices or self.clip.train_indices

    @property
    def frames_are(self) -> Literal["test", "training"]:
        """Held out; or, of a clip too short to hold one out, those that the run was trained on."""
        return "test" if self.record.test_indices else "training"

    def frames(self) -> Iterator[FrameMeasures]:
        """Measure the frames one after the other."""
        stopwatch = Stopwatch(self.model, self.clip.cameras[self.indices[0]], self.record.config.render_mode)
        for index in self.indices:
            frame = self.trained_clip.read_frame(index)
            drawn, milliseconds = stopwatch.draw(frame)
            yield measure_frame(frame, drawn, self.clip, self.lpips, milliseconds, self.seldom)

    def drawn(self, index: int) -> Rendered:
        """A frame of the model as its camera sees it."""
        camera, record = self.clip.cameras[index], self.record
        splats, near = self.model.at(record.time(index)), near_plane(self.model, camera)
        return draw_on_cpu(splats, camera, DrawOptions(near, record.config.render_mode))

    @cached_property
    def seldom(self) -> BoolImage | None:
        """(H, W), True where few training frames show tissue, and some; None where the camera moves."""
        fit, _ = split(self.clip, self.record.config)
        return seldom_seen(self.clip, fit)

    def report(self, frames: Sequence[FrameMeasures]) -> dict[str, Any]:
        """The JSON of `evaluate`."""
        clip, config = self.record.clip, self.record.config
        constant = {
            "n_gaussians": len(self.model),
            "train_seconds": self.run.train_seconds(),
            "wall_seconds": self.run.wall_seconds(),
        }
        return {
            "run": self.run.path.absolute().name,
            "clip": {"name": clip.name, "sha256": clip.sha256, "part": clip.part.of_anywhere},
            "method": config.method,
            "seed": config.seed,
            "input": self.record.input,
            "enhancement": self.record.enhancement,
            "edits": self.edits,
            "frames_are": self.frames_are,
            "evaluation_masks": clip.options.evaluation_masks,
            "gains": bool(self.record.exposure and self.record.exposure.gains),
            "evaluated_share": mean_of_finite(frame.evaluated_share for frame in frames),
            "mean": {name: mean_of_finite(getattr(frame, name) for frame in frames) for name in AVERAGED}
            | constant,
            **{name: _mean([getattr(frame, name) for frame in frames]) for name in GROUPS},
            "timed_with": {"threads": get_num_threads(), "load": load_average()},
            "peak_memory_mb": {"training": self._training_memory(), "evaluation": peak_memory_mb()},
            "frames": list(frames),
            "definitions": DEFINITIONS
            | {
                "frames_are": f"test: held out, {HELD_OUT[clip.options.split]}; "
                "training: the clip is too short to hold one out"
            }
            | {"method": departures(config.method), "defaults": CHOSEN}
            | {"lpips": LPIPS if self.lpips else no_lpips("vesselsplat/lpips in the user cache folder")},
        }

    def _training_memory(self) -> float | None:
        finished = self.run.events("Finished")
        return finished[-1].get("peak_memory_mb") if finished else None


def open_evaluation(run_path: Path, weights: Path | None = None, *, edited: bool = False) -> Evaluation:
    """`weights`: folder of those of LPIPS. The model as it was trained, which is what the method achieves;
    `edited`: as it is after what was done to it by hand.

    Raises:
        UserError, ClipError: no finished run, its clip is gone or has changed, or no weights where they are
            said to be.
    """
    run = RunFolder(run_path)
    record, model = run.record(), run.model()
    facts = {"measured": edited} if run.edits_path.is_file() else None
    if edited and (edits := read_edits(run, len(model))) is not None:
        model, facts = edits.applied(model), {"measured": True}
        facts |= {} if edits.is_empty else plain(RecordedEdits.of(edits))
    clip = run_clip(record)
    return Evaluation(run, record, clip, input_clip(clip, record), model, find_lpips(weights), facts)


def lpips_folder() -> Path:
    """Where the weights of LPIPS are looked for when nothing else is said."""
    return platformdirs.user_cache_path("vesselsplat", False) / "lpips"


def no_lpips(folder: object) -> str:
    """Why it was not measured; `folder`: how the one of `lpips_folder` is called."""
    if not has_torch():
        return f"not measured: {NO_TORCH}"
    return (
        f"not measured: put {WEIGHT_FILES}, into {folder}, "
        f"or name their folder by --lpips-weights or {LPIPS_VARIABLE}"
    )


def find_lpips(weights: Path | None) -> Lpips | None:
    """LPIPS with the weights in the folder given, else in that of the environment's VESSELSPLAT_LPIPS, else
    in the cache folder; None when there are none in the last, or they are not asked for and torch is not
    there. Raises UserError for any others that fail."""
    said = os.environ.get(LPIPS_VARIABLE)
    folder = weights or (Path(said) if said else None)
    if folder is None:
        folder = lpips_folder()
        if not weight_files(folder) or not has_torch():
            return None
    elif not has_torch():
        raise UserError(f"LPIPS of the weights in {folder}: {NO_TORCH}")
    try:
        return read_lpips(folder)
    except LpipsWeightsError as error:
        raise UserError(str(error)) from error


def measure_frame(
    frame: Frame,
    drawn: Rendered,
    clip: Clip,
    lpips: Lpips | None,
    milliseconds: Numbers,
    seldom: BoolImage | None = None,
) -> FrameMeasures:
    """Compare the picture of the model with `frame.image`, and both with the clip's own.

    seldom: (H, W), True where tissue was seldom seen; None: that is not known.
    """
    render, mask = drawn.bytes, frame.evaluation_mask
    shown = exposed(render, frame.gain) / 255.0
    original = clip.read_image(frame.index)
    vessels = vessel_mask(original, tissue_mask=mask, scale=line_scale(original))
    pair = None if frame.measured_depth is None else (drawn.depth, frame.measured_depth)
    return FrameMeasures(
        index=frame.index,
        label=clip.labels[frame.index],
        time=frame.time,
        evaluated_share=float(mask.mean()),
        lpips=None if lpips is None else lpips.distance(shown, frame.image / 255.0, mask),
        depth_rmse_mm=depth_rmse(*pair, mask) if pair and clip.unit == "mm" else None,
        depth=pair and {"abs_rel": depth_abs_rel(*pair, mask), "covered": depth_coverage(*pair, mask)},
        visibility=_visibility(render, original, mask, vessels),
        ms_per_frame=sum(milliseconds.values()),
        parts_ms=milliseconds,
        whole_picture=_dvbv(render),
        original_photo=_dvbv(original, mask) | _visibility(original, original, mask, vessels),
        input_photo=_dvbv(frame.image, mask) | _visibility(frame.image, original, mask, vessels),
        **vars(closeness(render, drawn.alpha, frame, seldom)),
        **_dvbv(render, mask),
    )


def _dvbv(image: ByteImage, mask: BoolImage | None = None) -> Numbers:
    measured = dvbv_otsu(image, tissue_mask=mask)
    return {"dv": measured.dv, "bv": measured.bv, "dv_bv": measured.ratio}


def _visibility(image: ByteImage, original: ByteImage, mask: BoolImage, vessels: BoolImage) -> Numbers:
    """Over the pixels of the mask; the ridges are the same for every picture of a frame."""
    return {
        "vessel_contrast": vessel_contrast(image, vessels, tissue_mask=mask, scale=line_scale(image)),
        "saturated_share": saturated_share(image, tissue_mask=mask),
        "dv_bv_local": dvbv_local(image, original, tissue_mask=mask).ratio,
    }


def _mean(groups: Sequence[Numbers | None]) -> dict[str, float | None]:
    taken = [group for group in groups if group is not None]
    names = taken[0] if taken else ()
    return {name: mean_of_finite(group[name] for group in taken) for name in names}


class Stopwatch:
    """Draws moments of a model as a player would, its working arrays kept, and takes the time."""

    def __init__(self, model: DynamicGaussians, camera: Camera, mode: RenderMode = "default") -> None:
        self._model, self._near, self._mode = model, near_plane(model, camera), mode
        self._rasterizer = Rasterizer(camera.width, camera.height)
        self._no_tile = np.zeros((self._rasterizer.rows, self._rasterizer.columns), dtype=bool)

    def draw(self, frame: Frame) -> tuple[Rendered, dict[str, float]]:
        """The picture at the frame's time from its camera, and the milliseconds of its parts."""
        # The first lap compiles kernels, reserves arrays and wakes the threads.
        drawn, _ = self._lap(frame)
        laps = [self._lap(frame)[1] for _ in range(REPEATS)]
        whole, deformation, sorting = 1000 * np.median(laps, axis=0)
        raster = max(0.0, float(whole - deformation - sorting))
        parts = {"deformation": float(deformation), "projection_sort": float(sorting), "raster": raster}
        return drawn, parts

    def _lap(self, frame: Frame) -> tuple[Rendered, tuple[float, float, float]]:
        """One picture; seconds of the whole, of the deformation, and of all before the raster."""
        camera, rasterizer = frame.camera, self._rasterizer
        began = time.perf_counter()
        splats = self._model.at(frame.time)
        deformed = time.perf_counter()
        rasterizer.forward(splats, camera, self._near, mode=self._mode)
        rendered = rasterizer.rendered(camera.width, camera.height, BLACK)
        done = time.perf_counter()
        rasterizer.forward(splats, camera, self._near, self._no_tile, self._mode)
        sorting = time.perf_counter() - done
        times = done - began, deformed - began, sorting
        return rendered, times
