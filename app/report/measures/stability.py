"""Stiff and extreme cases of every equation and kernel: what float32 makes of them, and the bar."""

from __future__ import annotations

from collections.abc import Iterable

import enhance.stability
import enhance.stability_row
import renderer.measuring.stability
from app.report.bench import Bench, Clock
from app.report.measures.enhancement import first_frame
from app.report.section import Cell, Column, Section, Table
from renderer.camera import Camera
from renderer.draw.context import OpenGLUnavailable, standalone_context
from renderer.draw.offscreen import render_offscreen
from renderer.measuring.stability.row import Row
from renderer.splats import Float32Array, Splats
from renderer.torch_presence import NO_TORCH, has_torch

COLUMNS = (
    *(Column("hazard"), Column("case"), Column("measured", ".3g"), Column("bar", ".3g"), Column("unit")),
    *(Column("verdict"), Column("remedy")),
)
SMALLER = 2
"""One pixel in so many along each side: the oracle is slow."""


def measure(bench: Bench, clock: Clock) -> Section:
    """Of both libraries; of drawing with OpenGL, where there is any."""
    bench.say("stability of the enhancement")
    tables = {
        "Enhancement": _cells(enhance.stability.stability(first_frame(bench)[::SMALLER, ::SMALLER].copy()))
    }
    bench.say("stability of reconstruction and rendering")
    missing = (
        [] if has_torch() else [f"images, depths, gradients and training steps against float64: {NO_TORCH}"]
    )
    try:
        context = standalone_context()
    except OpenGLUnavailable as error:
        missing.append(f"rendering with OpenGL: {error}")
        rows = _cells(renderer.measuring.stability.stability())
    else:

        def drawn(splats: Splats, camera: Camera, near: float) -> Float32Array:
            return render_offscreen(context, splats, camera, near=near)

        rows = _cells(renderer.measuring.stability.stability(drawn))
        context.release()
    tables["Reconstruction and rendering"] = rows
    failed = [row for rows in tables.values() for row in rows if row[5] is False]
    count = sum(len(rows) for rows in tables.values())
    return Section(
        title="Stability: stiff and extreme cases",
        sentences=(
            f"{count} cases, {len(failed)} failed. Each is computed in float32, as in use, against "
            "float64, against 50 decimal digits (projection), the clip's frames and depth (whole runs) "
            "or an exact requirement. Each is also a test, shown to fail with a deliberate fault.",
            *(f"Failed: {row[0]}, {row[1]}. Remedy: {row[6] or 'none'}." for row in failed),
        ),
        tables=tuple(Table(title=name, columns=COLUMNS, rows=rows) for name, rows in tables.items()),
        not_measured=tuple(missing),
    )


def _cells(rows: Iterable[enhance.stability_row.Row | Row]) -> tuple[tuple[Cell, ...], ...]:
    return tuple(
        (row.hazard, row.case, row.measured, row.bar, row.unit, row.passed, row.done) for row in rows
    )
