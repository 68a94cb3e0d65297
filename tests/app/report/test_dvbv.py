"""DV/BV by pixels and statistics, and when its rise holds."""

from __future__ import annotations

import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.report import dvbv
from app.report.bench import Bench, Clock
from app.report.dvbv import (
    FRAMES,
    PIXELS,
    STATISTICS,
    PixelSets,
    Rise,
    measured_rises,
    published,
    rises,
    verdict,
)
from app.report.measures import paper
from app.runs.train_run import pooled
from enhance import EnhanceParams, measure
from enhance.metrics import dvbv_otsu
from renderer.sources import open_clip
from renderer.train.config import TrainConfig
from tests.app.conftest import ROOT

PULLING = ROOT / "../shared/data/endonerf/pulling_soft_tissues"
MASKED = 12
"""Columns without stereo depth."""


@pytest.fixture
def two_masks(clip_path: Path, tmp_path: Path) -> Path:
    """A clip whose gt_masks leave out tools alone, its masks a band as well."""
    path = tmp_path / "clip"
    shutil.copytree(clip_path, path)
    for file in (path / "masks").iterdir():
        mask = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE)
        mask[:, :MASKED] = 255
        cv2.imwrite(str(file), mask)
    return path


@pytest.mark.parametrize(
    ("gains", "said"),
    [
        ((1.023, 1.003, 0.983), "not distinguishable from none"),
        ((1.023,), "one seed: undetermined"),
        ((1.14, 1.12, 1.16), "holds"),
        ((0.90, 0.91, 0.92), "does not hold"),
        ((1.05, 1.00, 1.10), "not distinguishable from none"),
        ((), "not measured"),
    ],
)
def test_a_rise_holds_by_the_spread_over_seeds(gains: tuple[float, ...], said: str) -> None:
    assert verdict(gains) == said


def test_only_seeds_that_both_sides_have_are_compared() -> None:
    original = {0: {"masks": 1.0, "whole image": 2.0}, 1: {"masks": 2.0, "whole image": 2.0}}
    found = list(rises("m", original, {"tissue": {1: {"masks": 3.0, "whole image": 5.0}}}))  # type: ignore[arg-type]
    assert [(one.pixels, one.gains) for one in found] == [("whole image", (2.5,)), ("masks", (1.5,))]
    assert Rise("m", "masks", "tissue", (0.0, 2.0), (1.0, 3.0)).gains == (1.5,)


def test_the_paper_prints_of_its_own_clip_or_of_all(clip_path: Path) -> None:
    clip = open_clip(clip_path)
    assert published("EndoGaussian", clip) == "pulling 1.21 to 1.76: 1.45; cutting 1.07 to 1.61: 1.50"
    assert published("VesselSplat", clip) == ""


def test_pixels_are_those_of_each_mask(two_masks: Path) -> None:
    sets = PixelSets.of(two_masks, open_clip(two_masks))
    masks = sets.masks(1)
    wide, narrow = masks["gt_masks"], masks["masks"]
    assert wide is not None
    assert narrow is not None
    assert not narrow[:, :MASKED].any()
    assert wide[:, :MASKED].any()
    picture = sets.clip.read_image(1)
    ratios = sets.ratios([(1, picture)])
    assert ratios["whole image"] == dvbv_otsu(picture).ratio
    assert ratios["gt_masks"] == dvbv_otsu(picture, tissue_mask=wide).ratio
    assert ratios["masks"] == dvbv_otsu(picture, tissue_mask=narrow).ratio
    assert len({*ratios.values()}) == 3
    shutil.rmtree(two_masks / "gt_masks")
    assert "gt_masks" not in PixelSets.of(two_masks, open_clip(two_masks)).masks(1)


def test_statistics_are_of_tissue_or_of_whole_pictures(two_masks: Path) -> None:
    clip, params = open_clip(two_masks), EnhanceParams()
    whole = measure([clip.read_image(index) for index in clip.train_indices], params, pixels="all")
    assert pooled(clip, params, "whole image").statistics == whole
    assert pooled(clip, params).statistics != whole


def test_all_pixels_and_statistics_stand_side_by_side(
    two_masks: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dvbv, "SEEDS", 2)
    monkeypatch.setattr(
        dvbv,
        "schedule",
        lambda clip, method: TrainConfig(method=method, iterations=4, n_gaussians=300),
    )
    bench, missing = Bench(two_masks, (), tmp_path / "work", lambda _: None), list[str]()
    found = list(measured_rises(bench, Clock.of(1000), {"vesselsplat": "Deform3DGS"}, missing))
    assert missing == []
    expected = [(pixels, statistics) for pixels in PIXELS for statistics in STATISTICS]
    for what in (FRAMES, "Deform3DGS"):
        assert [(one.pixels, one.statistics) for one in found if one.what == what] == expected
    table = dvbv.table(found, bench.clip)
    names = [column.name for column in table.columns]
    rows = [dict(zip(names, row, strict=True)) for row in table.rows]
    assert [row["seeds"] for row in rows] == [None] * 6 + [2] * 6
    assert all(row["the paper's renders"].startswith("pulling 0.93 to 1.47: 1.58") for row in rows[6:])
    assert all(row["± SD of seeds"] is not None for row in rows[6:])
    # What a run was trained on is another picture with other statistics.
    of_renders = {(one.pixels, one.statistics): one.enhanced for one in found[6:]}
    assert of_renders["masks", "tissue"] != of_renders["masks", "whole image"]
    told = list(paper._reading_of_rises(found))
    assert len(told) == 2
    assert "over gt_masks with statistics of whole image" in told[1]
    out_of_time = list(measured_rises(bench, Clock.of(-1), {"vesselsplat": "Deform3DGS"}, missing))
    assert {one.what for one in out_of_time} == {FRAMES}
    assert missing[-1].endswith("no time left")


@pytest.mark.data
@pytest.mark.skipif(not PULLING.is_dir(), reason="the pulling clip is not here")
def test_frames_of_the_pulling_clip_gain_as_the_pixels_and_statistics_are_taken(tmp_path: Path) -> None:
    bench = Bench(PULLING, (), tmp_path, lambda _: None)
    found = measured_rises(bench, Clock.of(-1), {}, [])
    gains = {(one.pixels, one.statistics): float(np.mean(one.gains)) for one in found}
    assert gains == pytest.approx(
        {
            ("whole image", "whole image"): 1.252,
            ("whole image", "tissue"): 1.194,
            ("gt_masks", "whole image"): 1.363,
            ("gt_masks", "tissue"): 1.261,
            ("masks", "whole image"): 1.092,
            ("masks", "tissue"): 1.046,
        },
        abs=0.005,
    )
