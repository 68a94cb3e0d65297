from __future__ import annotations

from renderer.measuring.drawing_row import Row
from renderer.measuring.raster_accuracy import accuracy, exact
from tests.renderer.scenes import random_splats, turned_camera

CAMERA = turned_camera(96, 80)
SPLATS = random_splats(400, CAMERA)
ROWS = list(accuracy(SPLATS, CAMERA, 0.01, exact(SPLATS, CAMERA, 0.01), repeats=1))


def group(name: str) -> list[Row]:
    return [row for row in ROWS if row.group == name]


def test_the_product_is_nearest_to_the_reference() -> None:
    (whole,) = group("whole")
    assert whole.mean < 1e-3
    assert all(row.mean >= whole.mean for row in ROWS)


def test_each_knob_trades_error_for_work() -> None:
    (whole,) = group("whole")
    cuts = [row for row in group("extent") if "alpha" in row.setting]
    sigmas = [row for row in group("extent") if "sigma" in row.setting]
    for rows in (cuts, sigmas, group("faint"), group("fewer"), group("pixels")):
        errors, entries = [row.mean for row in rows], [row.entries for row in rows]
        assert errors == sorted(errors)
        assert entries == sorted(entries, reverse=True)
        assert entries[-1] < whole.entries
        assert errors[-1] > whole.mean


def test_times_and_spreads_are_there() -> None:
    assert all(row.milliseconds > 0 and row.spread >= 0 and row.mean <= row.most for row in ROWS)
