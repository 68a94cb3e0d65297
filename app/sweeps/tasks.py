"""What is done in one job, in a worker: measures, and one image to look at."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import Any

from app.enhancement.enhance_files import Setting, enhanced, pooled_statistics, record_of
from app.enhancement.measures import METRICS, Measures, Original
from app.enhancement.methods import MethodEnhancer, load_kernels
from app.evaluation.evaluate import Evaluation, open_evaluation
from app.evaluation.mean import mean_of_finite
from app.files.atomic import filled
from app.files.color_profiles import profile_of
from app.files.image_files import write_image
from app.files.image_series import open_series
from app.files.provenance import provenance, write_png
from app.files.records import Source
from app.files.stepping import run_to_end
from app.runs.run_folder import RunFolder
from app.runs.train_run import RECONSTRUCTION_PARAMS, TrainRequest, run_training
from app.sweeps.jobs import PICTURE, RENDERS, RUN, SURFACE, Job, Keeps
from app.sweeps.settings import Enhancing, Meshing, Training
from app.sweeps.surfaces import mesh_measures
from renderer.train.checkpoint import checkpoint_paths

Numbers = dict[str, float | None]
"""Measures by name; None: not measured, or not finite."""


def carry_out(job: Job, clip: Path, folder: Path, keeps: Keeps) -> Numbers:
    """Do the job, with what is to be kept in `folder`, which exists.

    Raises:
        UserError, ClipError, ImageError, OSError: it cannot be done; each says why.
    """
    settings = job.settings
    if isinstance(settings, Enhancing):
        return _enhance(settings, job.frames, clip, folder)
    if isinstance(settings, Meshing):
        measures = _train(settings.training, clip, folder, keeps)
        measures |= mesh_measures(folder / RUN, folder / SURFACE, settings)
    else:
        measures = _train(settings, clip, folder, keeps)
    _clear(folder / RUN, keeps)
    return measures


def render_again(folder: Path) -> None:
    """All held-out frames, of the finished training in the folder of a job.

    Raises:
        UserError, ClipError, OSError: its model or its clip is gone or has changed.
    """
    _write_renders(open_evaluation(folder / RUN), folder)


def _enhance(wanted: Enhancing, frames: int, clip: Path, folder: Path) -> Numbers:
    """Means over evenly spread images; the middle one is written."""
    series = open_series(clip, wanted.options)
    setting = Setting(wanted.method, wanted.params, wanted.statistics, wanted.pixels, wanted.options)
    pooled = run_to_end(pooled_statistics(series, setting))
    indices = series.spread(frames)
    kept, enhancer, found = indices[len(indices) // 2], MethodEnhancer(), list[Measures]()
    for index in indices:
        image = series.read(index)
        if index == indices[0] and wanted.params is not None:
            load_kernels(wanted.params, image)
        record = record_of(series, index, Source.of(series.sources[index]), setting, pooled)
        began = perf_counter()
        result, record = enhanced(record, image, enhancer)
        milliseconds = 1000 * (perf_counter() - began)
        found.append(Original.of(image).measures(result, milliseconds))
        if index == kept and result.dtype.kind != "f":
            profile = profile_of(series.sources[index], result)
            write_image(folder / PICTURE, result, record.signed, profile=profile)
    means = {name: mean_of_finite(getattr(one, name) for one in found) for name in METRICS}
    return means | {"images": float(len(found))}


def _train(wanted: Training, clip: Path, folder: Path, keeps: Keeps) -> Numbers:
    """Train, going on from the checkpoint of a job that was killed, and evaluate: on test frames; with
    `hold_out` on held-out training frames alone."""
    run = folder / RUN
    request = TrainRequest(
        clip_path=clip,
        run_path=run,
        config=wanted.config,
        clip_options=wanted.options,
        input=wanted.input,
        enhance_params=wanted.params or RECONSTRUCTION_PARAMS,
        resume=RunFolder(run).is_run,
    )
    for _ in run_training(request):
        pass
    if wanted.config.hold_out:
        return _held_out(RunFolder(run))
    evaluation = open_evaluation(run)
    frames = list(evaluation.frames())
    report = evaluation.report(frames)
    middle = evaluation.indices[len(evaluation.indices) // 2]
    _write_render(evaluation, middle, folder / PICTURE)
    if keeps.renders:
        _write_renders(evaluation, folder)
    return {name: _finite(value) for name, value in report["mean"].items()}


def _held_out(run: RunFolder) -> Numbers:
    """Of training frames held out of the fit: settings are chosen without a look at the test frames."""
    last = run.events("Evaluated")[-1]
    unit = "depth_rmse_mm" if run.record().clip.unit == "mm" else "depth_rmse"
    return {
        "psnr": _finite(last["psnr"]),
        unit: _finite(last["depth_rmse"]),
        "n_gaussians": float(len(run.model())),
        "train_seconds": run.train_seconds(),
        "wall_seconds": run.wall_seconds(),
    }


def _clear(run: Path, keeps: Keeps) -> None:
    """Checkpoints are three times as large as the model."""
    for path in (*checkpoint_paths(run), *(() if keeps.model else (RunFolder(run).model_path,))):
        path.unlink()


def _write_renders(evaluation: Evaluation, folder: Path) -> None:
    """All held-out frames rendered into a folder, which appears when it is complete."""
    with filled(folder / RENDERS) as renders:
        for index in evaluation.indices:
            _write_render(evaluation, index, renders / f"frame-{index:06d}.png")


def _write_render(evaluation: Evaluation, index: int, path: Path) -> None:
    """Of one frame, from its camera."""
    record = evaluation.record
    facts = provenance(clip=record.clip.name, frame=index, method=record.config.method)
    write_png(path, evaluation.drawn(index).bytes, facts)


def _finite(value: Any) -> float | None:
    return mean_of_finite([None if value is None else float(value)])
