from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import astuple, replace
from functools import cache
from itertools import combinations, product
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Annotation

from app.report import visibility_front
from app.report.bench import Bench, Clock
from app.report.diagrams import Gain, GainDiagram, gain_front
from app.report.gain_plot import gain_figure
from app.report.measures import visibility
from app.report.page import page
from app.report.section import read_report
from app.report.visibility import Sample, methods, sample
from app.report.visibility_front import (
    DEFAULT,
    SHARES,
    STRENGTHS,
    UNCHANGED,
    WAYS,
    Seen,
    Setting,
    Visibility,
    above_vessel,
    area_under_curve,
    averaged,
    best_other,
    has_vessels,
    is_ahead,
    seen,
    thin_part,
)
from enhance import VesselParams, enhance_vessels, noise_gain, unsharp, vessel_contrast
from tests.app.conftest import Cli
from tests.enhance.pictures import vessels

GAINS = st.floats(0.2, 5)


@cache
def one() -> Sample:
    return sample(vessels(128, 160))


@cache
def found() -> Seen:
    return seen(one())


def diagram(pairs: list[tuple[float, float]]) -> GainDiagram:
    gains = (
        Gain(series="abc"[place % 3], setting=str(place), noise=noise, contrast=contrast)
        for place, (noise, contrast) in enumerate(pairs)
    )
    return GainDiagram(title="t", gains=tuple(gains))


def of_gains(noise: float, contrast: float) -> Visibility:
    values = dict.fromkeys(("thin", "cnr", "color", "auc", "highlight_halo", "edge_halo"), 1.0)
    return Visibility(noise=noise, contrast=contrast, **values)


def direct(result: np.ndarray) -> tuple[float, float]:
    before, after = (vessel_contrast(image, one().vessels, scale=0.25) for image in (one().image, result))
    return noise_gain(result, one().image), after / before


def test_the_points_are_those_of_the_direct_computation() -> None:
    gains = {(gain.series, gain.setting): gain for gain in visibility.diagram_of(found(), "t").gains}
    assert len(gains) == len(WAYS) * len(STRENGTHS) + 1 + len(SHARES) * (len(methods()) - 2)
    for (way, params), strength in product(WAYS.items(), STRENGTHS):
        gain = gains[way, f"strength {strength:g}"]
        own = enhance_vessels(one().image, replace(params, strength=strength)).image
        assert (gain.noise, gain.contrast) == pytest.approx(direct(own))
        assert gain.is_default is (replace(params, strength=strength) == VesselParams())
    for share in SHARES:
        gain = gains["unsharp", f"{share:.0%}"]
        blended = np.rint(share * unsharp(one().image).astype(np.float64) + (1 - share) * one().image)
        assert (gain.noise, gain.contrast) == pytest.approx(direct(blended.astype(np.uint8)), abs=0.01)
        assert gain.is_default is (share == 1)
    assert (gains["original", "unchanged"].noise, gains["original", "unchanged"].contrast) == (1, 1)


def test_what_a_method_clips_makes_none_of_its_shares_quieter(monkeypatch: pytest.MonkeyPatch) -> None:
    half = one().image.copy()
    half[:, :80] = 255
    few = {"original": methods()["original"], "half clipped": lambda image, tissue: half}
    monkeypatch.setattr(visibility_front, "methods", lambda: few)
    noise = {setting: each.noise for setting, each in seen(one()).items() if setting.method == "half clipped"}
    assert list(noise.values()) == [1] * len(SHARES)


def test_every_method_has_one_default() -> None:
    defaults = [setting.method for setting in found() if setting.is_default]
    assert sorted(defaults) == sorted(methods().keys() - {"original"})


def test_what_a_frame_keeps_has_neither_gains_nor_halos() -> None:
    kept = found()[Setting("original", "unchanged")]
    assert (kept.noise, kept.contrast, kept.thin, kept.cnr, kept.color) == (1, 1, 1, 1, 1)
    assert (kept.highlight_halo, kept.edge_halo) == (0, pytest.approx(0, nan_ok=True))
    assert kept.auc > 0.8


@given(st.lists(st.tuples(GAINS, GAINS), max_size=20))
def test_no_gain_beats_one_of_the_front_and_one_of_the_front_beats_any_other(
    pairs: list[tuple[float, float]],
) -> None:
    front = [(gain.noise, gain.contrast) for gain in gain_front(diagram(pairs))]
    assert front == sorted(front)
    for noise, contrast in front:
        assert not any(n <= noise and c >= contrast and (n, c) != (noise, contrast) for n, c in pairs)
    for noise, contrast in pairs:
        assert any(n <= noise and c >= contrast for n, c in front)


def test_the_best_other_is_of_another_method_with_no_more_noise() -> None:
    settings = [Setting("a", "1"), Setting("a", "2"), Setting("b", "1"), Setting("b", "2"), Setting("c", "1")]
    pairs = [(1.0, 1.5), (0.9, 3.0), (1.0, 1.4), (1.1, 2.0), (0.8, math.nan)]
    few = {setting: of_gains(*pair) for setting, pair in zip(settings, pairs, strict=True)}
    others = [best_other(setting, few) for setting in settings]
    assert others == [settings[2], None, settings[1], settings[1], None]
    assert [is_ahead(setting, few) for setting in settings[:4]] == [True, True, False, False]
    ways = [Setting(way, "1") for way in WAYS]
    assert best_other(ways[0], dict.fromkeys(ways, of_gains(1.0, 1.5))) is None


def test_what_is_above_vessel_has_more_contrast_than_its_settings_with_no_more_noise() -> None:
    pairs = {
        UNCHANGED: (1.0, 1.0),
        Setting("vessel", "1"): (1.1, 1.5),
        Setting("vessel, contrast 1", "2"): (1.2, 1.8),
        Setting("more noise, more contrast", "1"): (2.0, 1.9),
        Setting("more noise, less contrast", "1"): (2.0, 1.7),
        Setting("between its settings", "1"): (1.15, 1.6),
        Setting("less noise", "1"): (0.9, 1.1),
        Setting("less noise, fainter", "1"): (0.5, 0.4),
        Setting("bright vessels", "1"): (0.9, math.nan),
    }
    above = above_vessel({setting: of_gains(*pair) for setting, pair in pairs.items()})
    assert [setting.method for setting in above] == [
        "more noise, more contrast",
        "between its settings",
        "less noise",
    ]


def test_the_report_names_what_is_above_vessel() -> None:
    pairs = {
        UNCHANGED: (1.0, 1.0),
        Setting("vessel", "strength 2.4", is_default=True): (1.2, 1.8),
        Setting("loud", "100%"): (2.0, 1.9),
    }
    found = {setting: of_gains(*pair) for setting, pair in pairs.items()}
    assert any("loud, 100% (1.90 at 2.00)." in sentence for sentence in visibility._reading(found))
    del found[Setting("loud", "100%")]
    assert not any("More contrast than vessel" in sentence for sentence in visibility._reading(found))


def test_means_are_geometric_for_gains_and_of_what_was_measured() -> None:
    a, b = Setting("a", "1"), Setting("b", "1")
    halves = (of_gains(0.5, 2.0), of_gains(2.0, 8.0))
    bright = of_gains(1.0, -1.0)
    same = {UNCHANGED: of_gains(1.0, 1.0)}
    mean = averaged([{a: halves[0], b: bright} | same, {a: halves[1], b: halves[0]} | same])
    assert (mean[a].noise, mean[a].contrast) == pytest.approx((1.0, 4.0))
    assert math.isnan(mean[b].contrast)
    assert averaged([]) == {}


def test_an_image_without_vessels_counts_for_no_method() -> None:
    a = Setting("a", "1")
    seen_ = {a: of_gains(2.0, 3.0), UNCHANGED: of_gains(1.0, 1.0)}
    nothing = dict.fromkeys((a, UNCHANGED), of_gains(math.nan, math.nan))
    assert [has_vessels(each) for each in (seen_, nothing)] == [True, False]
    mean = averaged([nothing, seen_])
    assert (mean[a].noise, mean[a].contrast) == pytest.approx((2.0, 3.0))
    assert math.isnan(averaged([nothing])[a].contrast)


def test_a_black_frame_leaves_the_measures_of_the_others(
    clip_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    black = Sample(np.full_like(one().image, 3), one().tissue, np.zeros_like(one().vessels))
    few = {name: method for name, method in methods().items() if name in ("original", "paper", "vessel")}
    monkeypatch.setattr(visibility_front, "methods", lambda: few)
    monkeypatch.setattr(visibility, "of_clip", lambda path, frames: [black, one(), one()])
    part = visibility.measure(bench(clip_path, tmp_path), Clock.of(1000))
    assert part.not_measured == ("1 of 3 images: no vessels were found, or no noise",)
    assert "over 2 images" in part.sentences[0]
    monkeypatch.setattr(visibility, "of_clip", lambda path, frames: [one()])
    alone = visibility.measure(bench(clip_path, tmp_path), Clock.of(1000))
    assert len(part.gain_diagrams[0].gains) == len(alone.gain_diagrams[0].gains) > 2
    for both, single in zip(part.gain_diagrams[0].gains, alone.gain_diagrams[0].gains, strict=True):
        assert (both.noise, both.contrast) == pytest.approx((single.noise, single.contrast))


def test_the_area_is_1_for_vessels_that_are_darkest_and_a_half_for_any_pixels() -> None:
    image = np.full((64, 64, 3), 150, np.uint8)
    image[:, 30:33] = 90
    truth = np.zeros((64, 64), bool)
    truth[:, 30:33] = True
    everywhere = np.ones((64, 64), bool)
    assert area_under_curve(image, Sample(image, everywhere, truth)) == 1
    alike = np.zeros((64, 64), bool)
    alike[::2] = True
    assert area_under_curve(image, Sample(image, everywhere, alike)) == pytest.approx(0.5)
    assert math.isnan(area_under_curve(image, Sample(image, everywhere, everywhere)))


def test_thin_vessels_are_those_that_a_disc_does_not_fit_into() -> None:
    both = np.zeros((200, 200), bool)
    both[:, 50:52] = both[:, 120:130] = True
    columns = np.flatnonzero(thin_part(both).any(axis=0))
    assert columns.tolist() == [50, 51]
    both[:, 50:52] = False
    assert (thin_part(both) == both).all()


def test_an_image_without_vessels_has_no_gains() -> None:
    flat = np.full((64, 64, 3), 120, np.uint8)
    nothing = seen(sample(flat))
    assert all(math.isnan(each.contrast) for each in nothing.values())
    assert not visibility.diagram_of(nothing, "t").gains


def test_names_do_not_lie_on_each_other_and_within_the_diagram() -> None:
    figure = gain_figure(visibility.diagram_of(found(), "t"))
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    [axes] = figure.axes
    names = [each for each in axes.texts if isinstance(each, Annotation)]
    assert f"vessel, strength {DEFAULT:g}" in {name.get_text() for name in names}
    boxes = [name.get_window_extent(canvas.get_renderer()) for name in names]
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
    assert all(box.x0 > axes.get_window_extent().x0 for box in boxes)
    drawn = {line.get_label() for line in axes.lines}
    assert drawn >= {*methods(), "Pareto front"}


def bench(given_: Path | None, tmp_path: Path) -> Bench:
    return Bench(given_, (), tmp_path, lambda line: None)


def test_what_there_is_no_time_for_is_named(
    clip_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    none = visibility.measure(bench(clip_path, tmp_path), Clock(-math.inf))
    assert none.not_measured == tuple(f"image {number}: no time left" for number in (1, 2, 3))
    assert none.gain_diagrams == none.tables == none.sentences == ()
    assert "no time left" in page({"visibility": none}, {})

    def clocks() -> Iterator[bool]:
        yield from (False, True, True)

    answers = clocks()
    monkeypatch.setattr(Clock, "is_out", property(lambda clock: next(answers)))
    monkeypatch.setattr(visibility, "seen", lambda one_: found())
    part = visibility.measure(bench(clip_path, tmp_path), Clock(0))
    assert part.not_measured == ("image 2: no time left", "image 3: no time left")
    assert "over 1 image." in part.sentences[0]


def test_a_clip_without_vessels_is_reported_as_such(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "even.png"), np.full((64, 80, 3), 120, np.uint8))
    part = visibility.measure(bench(tmp_path / "even.png", tmp_path), Clock.of(1000))
    assert part.not_measured == ("contrast: no vessels were found",)
    assert part.gain_diagrams == ()


def test_the_report_holds_diagram_and_table(vesselsplat: Cli, tmp_path: Path) -> None:
    out, clip = tmp_path / "report", tmp_path / "one.png"
    cv2.imwrite(str(clip), one().image[..., ::-1])
    call = vesselsplat("report", "--clip", clip, "--out", out, "--parts", "visibility")
    assert call.code == 0, call.error
    part = json.loads((out / "report.json").read_text())["parts"]["visibility"]
    [stored] = part["gain_diagrams"]
    assert len(stored["gains"]) == len(part["tables"][0]["rows"]) == len(found())
    assert "halo at highlights" in [column["name"] for column in part["tables"][0]["columns"]]
    section = read_report(out / "report.json").sections["visibility"]
    row = section.tables[0].rows[0]
    gain = section.gain_diagrams[0].gains[0]
    assert row[:4] == (gain.series, gain.setting, gain.noise, gain.contrast)
    html = (out / "report.html").read_text()
    assert html.count("<figure>") == 1
    assert visibility.TITLE in html


def test_the_table_has_a_heading_for_every_measure() -> None:
    made = visibility.table(found())
    assert all(len(row) == len(made.columns) for row in made.rows)
    assert {len(astuple(each)) for each in found().values()} == {8}
