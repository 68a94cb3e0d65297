"""Error against run time of drawing: the CPU rasteriser, OpenGL, and keyframes over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.report.bench import Bench, Clock
from app.report.diagrams import Point
from app.report.runs import schedule
from app.report.section import Cell, Column, Plate, Section, Table
from renderer.camera import Camera
from renderer.draw.context import OpenGLUnavailable, renderer_name, standalone_context
from renderer.gaussians import DynamicGaussians
from renderer.measuring import drawing_accuracy, raster_accuracy
from renderer.measuring.drawing_row import Row
from renderer.measuring.raster_accuracy import exact
from renderer.near_plane import middle_distance, near_plane
from renderer.splats import Splats
from renderer.torch_presence import NO_TORCH, has_torch

Group = tuple[str, Sequence[Row], tuple[Column, ...]]
"""Title, rows and columns of a table."""
TITLE: Final = "Rendering: error against run time"
COLUMNS: Final = (
    *(Column("changed"), Column("setting"), Column("mean error, grey levels", best="low")),
    *(Column("99.9th percentile"), Column("largest"), Column("ms", ".2f", "low"), Column("± ms", ".2f")),
)
ENTRIES: Final = Column("entries")
PSNR: Final = Column("PSNR, dB", ".1f", "high")
KEPT: Final = (Column("MB", ".2f"), Column("baking, s", ".2f"))
DEFAULTS: Final = ("unchanged", drawing_accuracy.EXPORT, "every frame, 0.02 px")


def measure(bench: Bench, clock: Clock) -> Section:
    """On the trained model, from the camera of a held-out frame."""
    if bench.why_untrained is not None:
        return Section(title=TITLE, not_measured=(f"no trained model: {bench.why_untrained}",))
    index = bench.clip.test_indices[0] if bench.clip.test_indices else 0
    model, camera = bench.runs.trained(schedule(bench.clip)).finished.model, bench.clip.cameras[index]
    size, time = f"{camera.width}x{camera.height}", bench.clip.times[index]
    bench.say(f"rendering of {len(model)} Gaussians at {size} against float64")
    splats, near = model.at(time), near_plane(model, camera)
    truth = exact(splats, camera, near) if has_torch() else None
    groups: list[Group] = []
    missing: list[str] = []
    if truth is None:
        missing.append(f"rendering against float64: {NO_TORCH}")
    else:
        rows = list(raster_accuracy.accuracy(splats, camera, near, truth))
        groups.append(("CPU rasteriser", rows, (*COLUMNS, ENTRIES)))
    try:
        groups += _opengl(bench, model, splats, camera, near, truth)
    except OpenGLUnavailable as error:
        missing.append(f"rendering with OpenGL: {error}")
    return Section(
        title=TITLE,
        sentences=(
            f"{len(model)} Gaussians of the trained model at {size}, against the float64 reference; "
            "keyframes against images of the model computed for each moment. An entry is a pair of a tile "
            "and a Gaussian.",
        ),
        plates=tuple(Plate.of_errors(name, map(_point, those)) for name, those, _ in groups),
        tables=tuple(
            Table(title=name, columns=columns, rows=tuple(map(_cells, those)))
            for name, those, columns in groups
        ),
        not_measured=tuple(missing),
    )


def _opengl(
    bench: Bench,
    model: DynamicGaussians,
    splats: Splats,
    camera: Camera,
    near: float,
    truth: NDArray[np.float64] | None,
) -> list[Group]:
    """Keyframes alone where there is no `truth`."""
    context = standalone_context()
    bench.say(f"rendering with {renderer_name(context)}")
    made: list[Group] = []
    if truth is not None:
        drawn = list(drawing_accuracy.opengl(context, splats, camera, near, truth))
        made.append((f"OpenGL, {renderer_name(context)}", drawn, (*COLUMNS, PSNR)))
    pixel = middle_distance(model, camera) / camera.fx
    kept = list(drawing_accuracy.keyframes(context, model, camera, bench.clip.times, near, pixel))
    made.append(("Keyframes over time", kept, (*COLUMNS, *KEPT)))
    context.release()
    return made


def _point(row: Row) -> Point:
    return Point(
        series=row.group,
        setting=row.setting,
        seconds=row.milliseconds / 1000,
        error=row.mean,
        spread=row.spread / 1000,
        is_default=row.setting in DEFAULTS,
    )


def _cells(row: Row) -> tuple[Cell, ...]:
    common = (row.group, row.setting, row.mean, row.p999, row.most, row.milliseconds, row.spread)
    if row.entries is not None:
        return (*common, row.entries)
    return (*common, row.psnr) if row.group == "OpenGL" else (*common, row.megabytes, row.baking)
