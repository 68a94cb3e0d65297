"""What is measured of an image inside a black surround: the field of view, however wide the surround is."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from app.enhancement.enhance_files import Setting, pooled_statistics
from app.enhancement.parameter_grid import axis, settings, tried
from app.exports.records import MeasuresTable
from app.files.image_files import read_image
from app.files.image_series import Series
from app.files.provenance import read_provenance, write_png
from app.report.visibility import COLUMNS, measured, sample
from enhance import EnhanceParams
from enhance.metrics import dvbv_local, dvbv_otsu, saturated_share
from enhance.ridges import field_of_view
from renderer.clip import ByteImage
from tests.app.conftest import Cli
from tests.enhance.pictures import vessels

NARROW, WIDE = 20, 90
"""Columns of the surround at either side."""
MEASURED = ("dv", "bv", "dv_bv", "saturated_share")


def framed(columns: int) -> ByteImage:
    """Tissue that a noisy, nearly black surround lies around, with a highlight."""
    tissue = vessels(120, 150)
    tissue[30:34, 30:40] = 255
    image = cv2.copyMakeBorder(tissue, 20, 20, columns, columns, cv2.BORDER_CONSTANT)
    dark = image.max(axis=2) == 0
    image[dark] = np.random.default_rng(3).integers(0, 4, (int(dark.sum()), 3))
    return np.asarray(image, np.uint8)


def of_view(image: ByteImage, view: np.ndarray) -> dict[str, float]:
    otsu = dvbv_otsu(image, tissue_mask=view)
    share = saturated_share(image, tissue_mask=view)
    return dict(zip(MEASURED, (otsu.dv, otsu.bv, otsu.ratio, share), strict=True))


def those(found: Mapping[str, Any]) -> dict[str, float]:
    return {name: found[name] for name in MEASURED}


@pytest.fixture
def paths(tmp_path: Path) -> dict[int, Path]:
    made = {}
    for columns in (NARROW, WIDE):
        made[columns] = tmp_path / f"{columns}.png"
        cv2.imwrite(str(made[columns]), framed(columns)[..., ::-1])
    return made


def test_a_grid_measures_the_field_of_view() -> None:
    wanted = settings(EnhanceParams(), [axis("d_factor=0:2:2", EnhanceParams)])
    image = framed(WIDE)
    view = field_of_view(image)
    assert 0.2 < view.mean() < 0.5
    for cell in tried(image, wanted):
        assert those(asdict(cell.measures)) == of_view(cell.image, view)
    for cell in tried(image, wanted, measured_over="whole image"):
        assert cell.measures.dv_bv == dvbv_otsu(cell.image).ratio
        assert cell.measures.saturated_share == saturated_share(cell.image)


def test_a_sheet_and_a_table_that_do_not_say_are_of_the_whole_image(
    paths: dict[int, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    call = vesselsplat("tune", paths[WIDE], "--out", tmp_path / "out", "--vary", "d_factor=0:2:2")
    assert call.code == 0, call.error
    sheet = tmp_path / "out" / "sheet.png"
    assert read_provenance(sheet)["measured_over"] == "field of view"
    assert read_provenance(sheet)["noise_cut"] == "unclipped"
    assert read_provenance(sheet)["lengths"] == "by size"
    assert "identical" in vesselsplat("replay", sheet, "--source", paths[WIDE]).out
    facts = read_provenance(sheet)
    del facts["measured_over"]
    write_png(sheet, read_image(sheet), facts)
    assert "identical" not in vesselsplat("replay", sheet, "--source", paths[WIDE]).out, "another DV/BV"
    before = MeasuresTable(first_frame=0, last_frame=1)
    assert (before.measured_over, before.noise_cut, before.lengths) == (
        "whole image",
        "by level",
        "in pixels",
    )


def test_metrics_are_of_the_field_of_view_and_say_what_is_not(
    paths: dict[int, Path], vesselsplat: Cli
) -> None:
    found = {}
    for columns, path in paths.items():
        report = json.loads(vesselsplat("metrics", path, "--against", path, "--json").out)
        image = framed(columns)
        view = field_of_view(image)
        (one,) = report["images"]
        assert those(one) == those(one["original"]) == of_view(image, view)
        assert one["dv_bv_whole"] == dvbv_otsu(image).ratio
        assert one["dv_bv_local"] == dvbv_local(image, image, tissue_mask=view).ratio
        assert {"pixels", "dv_bv_whole"} <= report["definitions"].keys()
        found[columns] = one
    narrow, wide = found[NARROW], found[WIDE]
    assert wide["dv_bv"] == pytest.approx(narrow["dv_bv"], rel=0.05)
    assert wide["dv_bv_local"] == pytest.approx(narrow["dv_bv_local"], rel=0.05)
    assert wide["dv_bv_whole"] > 2 * narrow["dv_bv"]


def test_table_3_measures_local_detail_and_saturation_of_the_tissue() -> None:
    image = framed(WIDE)
    view = field_of_view(image)
    row = dict(zip(COLUMNS, measured({"original": lambda one, _: one}, [sample(image, view)])["original"],
                   strict=True))  # fmt: skip
    assert row["ratio"] == dvbv_local(image, image, tissue_mask=view).ratio
    assert row["sat%"] == 100 * saturated_share(image, tissue_mask=view)
    assert row["whole"] == dvbv_otsu(image).ratio


def test_metrics_leave_out_what_is_transparent(tmp_path: Path, vesselsplat: Cli) -> None:
    image = vessels(120, 150)
    alpha = np.full(image.shape[:2], 255, np.uint8)
    alpha[80:] = 0
    dirty = image.copy()
    dirty[80:] = np.random.default_rng(5).integers(0, 256, dirty[80:].shape)
    for name, colors in (("clean", image), ("dirty", dirty)):
        cv2.imwrite(str(tmp_path / f"{name}.png"), np.dstack((colors[..., ::-1], alpha)))
    clean, dirty_path = tmp_path / "clean.png", tmp_path / "dirty.png"
    means = [
        json.loads(vesselsplat("metrics", path, "--against", clean, "--json").out)["mean"]
        for path in (clean, dirty_path)
    ]
    assert means[0] == means[1]
    assert means[0]["psnr"] is None  # Infinite: what is seen is the same.


def test_the_search_for_the_surround_can_be_stopped_after_each_image() -> None:
    """Cancelled in the window, or by Ctrl+C."""
    image, read = framed(WIDE), list[int]()

    def reading(index: int) -> ByteImage:
        read.append(index)
        return image

    names = tuple(map(str, range(8)))
    series = Series(names, tuple(map(Path, names)), reading, is_video=True)
    steps = pooled_statistics(series, Setting("paper", EnhanceParams(), pixels="tissue"))
    counts = [len(read) for _ in steps]
    assert len(counts) > 2 * len(series)
    assert max(np.diff([0, *counts])) <= 2
