"""Error against run time of the enhancement, over all of its parameters."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.report.bench import Bench, Clock
from app.report.diagrams import Point
from app.report.section import Column, Plate, Section, Table
from enhance.accuracy import EXACT, Row, accuracy
from renderer.phantom import Phantom, PhantomParams

DRAWN: Final = ("subsample", "scales", "both")
"""Groups with one truth, that the product offers."""
REPEATS: Final = 61
WHOLE: Final = " + ".join(map(str, EXACT.radii))
DEFAULT: Final = ("subsample", "s = 2")
COLUMNS: Final = (
    *(Column("changed"), Column("setting"), Column("mean error, grey levels"), Column("99.9th percentile")),
    *(Column("largest"), Column("bound"), Column("ms", ".2f"), Column("± ms", ".2f")),
)


def measure(bench: Bench, clock: Clock) -> Section:
    """On the first frame of the clip; of the phantom, drawn as large as an endoscope's picture."""
    image = first_frame(bench)
    height, width = image.shape[:2]
    bench.say(f"enhancement of an image of {width}x{height} against float64")
    rows = list(accuracy(image, REPEATS))
    # All three scales are among the rows of "subsample" already.
    drawn = [row for row in rows if row.group in DRAWN and row.setting != WHOLE]
    return Section(
        title="Enhancement: error against run time",
        sentences=(
            f"One image of {width}x{height} with its statistics, a frame of a stream. The error is against "
            "a literal float64 implementation of Eqs 1-12 with three scales and without subsampling; for "
            "arithmetic, with the same subsampling; for omissions, against the same with the part kept. "
            "Times are medians.",
        ),
        plates=(Plate.of_errors("Enhancement", map(_point, drawn)),),
        tables=(
            Table(
                title="Every parameter",
                columns=COLUMNS,
                rows=tuple(
                    (row.group, row.setting, row.mean, row.p999, row.most, row.bound, row.milliseconds,
                     row.spread)
                    for row in rows
                ),
                note="± is half the interquartile range. \"sampling\" is what the program does "
                "not do. The bound is known before anything is computed.",
            ),
        ),
    )  # fmt: skip


def first_frame(bench: Bench) -> NDArray[np.uint8]:
    """What pictures are measured on."""
    if bench.truth is None:
        return bench.clip.read_image(0)
    return Phantom(PhantomParams(width=640, height=512)).view(0).frame.image


def _point(row: Row) -> Point:
    assert row.milliseconds is not None
    return Point(
        series=row.group,
        setting=row.setting,
        seconds=row.milliseconds / 1000,
        error=row.mean,
        spread=(row.spread or 0.0) / 1000,
        is_default=(row.group, row.setting) == DEFAULT,
    )
