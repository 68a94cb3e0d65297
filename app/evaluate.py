"""A finished run measured on its held-out frames, against the photos that it was trained on."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from app.drawing import Drawn, draw_on_cpu, near_plane
from app.errors import UserError
from app.mean import mean_of_finite
from app.provenance import digest
from app.run_folder import RunFolder, RunRecord
from app.training import input_clip
from enhance.metrics import dvbv_otsu
from renderer.clip import BoolImage, ByteImage, Clip, Frame
from renderer.gaussians import DynamicGaussians
from renderer.metrics import depth_rmse, psnr, psnr_masked, ssim
from renderer.sources import open_clip

DEFINITIONS = {
    "psnr": "dB, both pictures times the evaluation mask, mean over all pixels, render rounded to 8 bits",
    "psnr_masked": "dB, mean over the evaluated pixels only",
    "dv_bv": "inferred definition: variances of grey above and below each picture's own Otsu threshold, "
    "over the evaluated pixels, so that what is under tools or never seen does not count",
    "whole_picture": "the same over every pixel of the render, black where nothing was reconstructed",
    "lpips": "not measured: its weights are not part of this program",
    "frames_are": "test: held out, (index - 1) % 8 == 0; training: the clip is too short to hold one out",
    "mean": "mean over the frames; means leave out what was not measured, is infinite or undefined",
}


@dataclass(frozen=True, kw_only=True)
class FrameMeasures:
    """One frame; NaN where a measure is undefined, None where it was not taken."""

    index: int
    label: str
    time: float
    psnr: float
    psnr_masked: float
    ssim: float
    lpips: float | None
    depth_rmse_mm: float | None
    dv: float
    bv: float
    dv_bv: float
    ms_per_frame: float
    whole_picture: dict[str, float]
    """DV, BV and their ratio over every pixel of the render."""
    original_photo: dict[str, float]
    """The same over the evaluated pixels of the clip's own photo."""
    input_photo: dict[str, float]
    """And of the photo that the run was trained on."""


AVERAGED = ("psnr", "psnr_masked", "ssim", "lpips", "depth_rmse_mm", "dv", "bv", "dv_bv", "ms_per_frame")


@dataclass(frozen=True, eq=False)
class Evaluation:
    """All that is needed to measure a run."""

    run: RunFolder
    record: RunRecord
    clip: Clip
    photos: Clip
    """The clip with the photos that the run was trained on."""
    model: DynamicGaussians

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
        first = self.photos.read_frame(self.indices[0])
        near = near_plane(self.model, first.camera)
        # The first picture compiles the kernels: it is not part of the time a picture takes.
        draw_on_cpu(self.model.at(first.time), first.camera, near)
        for index in self.indices:
            frame = self.photos.read_frame(index)
            began = time.perf_counter()
            drawn = draw_on_cpu(self.model.at(frame.time), frame.camera, near)
            seconds = time.perf_counter() - began
            original = self.clip.read_image(index)
            yield measure_frame(frame, drawn, original, self.clip.labels[index], self.clip.unit, seconds)

    def report(self, frames: Sequence[FrameMeasures]) -> dict[str, Any]:
        """The JSON of `evaluate`."""
        constant = {"n_gaussians": len(self.model), "train_seconds": self.run.train_seconds()}
        return {
            "run": self.run.path.absolute().name,
            "clip": {"name": self.record.clip.name, "sha256": self.record.clip.sha256},
            "method": self.record.config.method,
            "input": self.record.input,
            "frames_are": self.frames_are,
            "mean": {name: mean_of_finite(getattr(frame, name) for frame in frames) for name in AVERAGED}
            | constant,
            "whole_picture": _mean_photo(frame.whole_picture for frame in frames),
            "original_photo": _mean_photo(frame.original_photo for frame in frames),
            "input_photo": _mean_photo(frame.input_photo for frame in frames),
            "frames": list(frames),
            "definitions": DEFINITIONS,
        }


def open_evaluation(run_path: Path) -> Evaluation:
    """Raises UserError or ClipError: no finished run, or its clip is gone or has changed."""
    run = RunFolder(run_path)
    record, model = run.record(), run.model()
    clip = run_clip(record)
    return Evaluation(run, record, clip, input_clip(clip, record), model)


def run_clip(record: RunRecord) -> Clip:
    """The clip that the run was trained on. Raises UserError when it is not the same any more."""
    path = Path(record.clip.path)
    clip = open_clip(path, record.clip.options)
    if digest(path) != record.clip.sha256:
        raise UserError(f"expected the clip that the run was trained on, its files have changed: {path}")
    return clip


def measure_frame(
    frame: Frame, drawn: Drawn, original: ByteImage, label: str, unit: str, seconds: float
) -> FrameMeasures:
    """Compare the picture of the model with the photo `frame.image`."""
    render, photo, mask = drawn.bytes / 255.0, frame.image / 255.0, frame.evaluation_mask
    return FrameMeasures(
        index=frame.index,
        label=label,
        time=frame.time,
        psnr=psnr(render, photo, mask),
        psnr_masked=psnr_masked(render, photo, mask),
        ssim=ssim(render, photo, mask),
        lpips=None,
        depth_rmse_mm=_depth_error(frame, drawn) if unit == "mm" else None,
        ms_per_frame=1000.0 * seconds,
        whole_picture=_dvbv(drawn.bytes),
        original_photo=_dvbv(original, mask),
        input_photo=_dvbv(frame.image, mask),
        **_dvbv(drawn.bytes, mask),
    )


def _depth_error(frame: Frame, drawn: Drawn) -> float | None:
    if frame.depth is None:
        return None
    return float(depth_rmse(drawn.depth, frame.depth, frame.evaluation_mask))


def _dvbv(image: ByteImage, mask: BoolImage | None = None) -> dict[str, float]:
    measured = dvbv_otsu(image, tissue_mask=mask)
    return {"dv": measured.dv, "bv": measured.bv, "dv_bv": measured.ratio}


def _mean_photo(photos: Iterator[dict[str, float]]) -> dict[str, float | None]:
    listed = list(photos)
    return {name: mean_of_finite(photo[name] for photo in listed) for name in ("dv", "bv", "dv_bv")}
