"""Error against run time of drawing: the CPU rasteriser's knobs against the float64 reference."""

from __future__ import annotations

from typing import Final

from app.report.bench import Bench, Clock
from app.report.measures.training import schedule
from app.report.section import Column, Plate, Section, Table
from app.report.work_precision import Diagram, Point
from renderer.near_plane import near_plane
from renderer.rasterize.accuracy import Row, accuracy

COLUMNS: Final = (
    *(Column(name="what is changed"), Column(name="setting")),
    Column(name="mean error, grey levels", best="low"),
    *(Column(name="99.9th percentile"), Column(name="largest")),
    *(Column(name="entries"), Column(name="ms", form=".2f", best="low"), Column(name="± ms", form=".2f")),
)
WIDEST: Final = 400
"""Pixels of the view: in the reference every pixel looks at every Gaussian."""


def measure(bench: Bench, clock: Clock) -> Section:
    """On the trained model, from the camera of a held-out frame."""
    index = bench.clip.test_indices[0] if bench.clip.test_indices else 0
    trained = bench.runs.trained(schedule(bench.clip))
    model, camera = trained.finished.model, bench.clip.cameras[index]
    divisor = -(-camera.width // WIDEST)
    camera = camera.resized(camera.width // divisor, camera.height // divisor)
    size = f"{camera.width}x{camera.height}"
    bench.say(f"drawing of {len(model)} Gaussians at {size} against float64")
    splats, near = model.at(bench.clip.times[index]), near_plane(model, camera)
    rows = list(accuracy(splats, camera, near))
    points = tuple(_point(row) for row in rows)
    return Section(
        title="Drawing: error against run time",
        sentences=(
            f"{len(model)} Gaussians of the trained model at {size}, against the float64 reference in which "
            "every pixel looks at every Gaussian. An entry is a pair of a tile and a Gaussian.",
        ),
        plates=(
            Plate(
                title="CPU rasteriser",
                diagrams=(Diagram(measure="mean error, grey levels", points=points),),
            ),
        ),
        tables=(
            Table(
                title="CPU rasteriser",
                columns=COLUMNS,
                rows=tuple(
                    (row.group, row.setting, row.mean, row.p999, row.most, row.entries, row.milliseconds,
                     row.spread)
                    for row in rows
                ),
                note="\"whole\" is the product; the others show what its bounds are worth.",
            ),
        ),
    )  # fmt: skip


def _point(row: Row) -> Point:
    return Point(
        series=row.group,
        setting=row.setting,
        seconds=row.milliseconds / 1000,
        error=row.mean,
        spread=row.spread / 1000,
        is_default=row.group == "whole",
    )
