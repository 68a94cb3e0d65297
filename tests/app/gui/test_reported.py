"""The report panel: what it reads, what it draws, and where the present setting is."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import ImVec2, imgui

from app.errors import UserError
from app.files.provenance import provenance, strict_json
from app.gui.actions import actions, arriving
from app.gui.panels.report import draw_report
from app.gui.state.app_state import AppState
from app.gui.work.opening import OpenRequest, open_path
from app.gui.work.reported import LEAST, Scale, charts_of, current, read_reported
from app.report.diagrams import Curve, Diagram, Gain, GainDiagram, Growth, Point
from app.report.section import Plate, Section
from enhance import EnhanceParams
from enhance.vessel import VesselParams
from tests.app.gui.ui import Shown, Ui

POINTS = (
    Point(series="subsample", setting="s = 2", seconds=0.002, error=0.01, is_default=True),
    Point(series="subsample", setting="s = 1", seconds=0.006, error=0.0),
    Point(series="scales", setting="4 + 16", seconds=0.003, error=0.2),
)
GROWTH = Growth(
    title="ms against pixels", work="pixels", cost="ms",
    curves=(
        Curve.through("square", (1e3, 1e4, 1e5), (2e-2, 2.0, 2e2)),
        Curve.through("flat", (1e3, 1e5), (5.0, 5.0)),
    ),
)  # fmt: skip

GAINS = GainDiagram(
    title="contrast against noise",
    gains=(
        Gain(series="a", setting="1", noise=1.1, contrast=1.5),
        Gain(series="a", setting="2", noise=1.2, contrast=2.0, is_default=True),
        Gain(series="b", setting="100%", noise=2.0, contrast=1.2),
    ),
)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    diagrams = (Diagram(measure="mean error, grey levels", points=POINTS),)
    psnr = (Diagram(measure="PSNR, dB", points=POINTS, more_is_better=True),)
    sections = {
        "enhancement": Section(
            title="E", sentences=("words",), plates=(Plate(title="P", diagrams=diagrams),)
        ),
        "training": Section(title="T", plates=(Plate(title="Q", diagrams=psnr),)),
        "growth": Section(title="G", growths=(GROWTH,)),
        "visibility": Section(title="V", gain_diagrams=(GAINS,)),
    }
    facts = provenance(machine={"cores": 2, "processor": "p"}, clip={"name": "c"}, parts=sections)
    file = tmp_path / "report.json"
    file.write_text(strict_json(facts))
    return file


def test_long_run_times_are_counted_in_seconds() -> None:
    slow = tuple(replace(point, seconds=1e4 * point.seconds) for point in POINTS)
    plates = tuple(
        Plate(title=title, diagrams=(Diagram(measure="m", points=points),))
        for title, points in (("fast", POINTS), ("slow", slow))
    )
    fast, late = charts_of({"t": Section(title="T", plates=plates)})
    assert (fast.against, late.against) == ("ms", "s")
    assert fast.series[0].across.tolist() == pytest.approx([2, 6])
    assert late.series[0].across.tolist() == pytest.approx([20, 60])
    assert late.place(slow[0]) == (pytest.approx(20), 0.01)
    assert (fast.told(POINTS[0]), late.told(slow[0])) == ("0.01 in 2 ms", "0.01 in 20 s")


def test_charts_are_ready_to_draw(path: Path) -> None:
    first, second, *_ = read_reported(path).charts
    assert first.logarithmic
    assert not second.logarithmic
    assert first.front is not None
    assert np.all(np.diff(first.front.across) > 0)
    assert first.across.least < 2 < 6 < first.across.most
    assert first.across.ticks == (2.0, 3.0, 4.0, 5.0)
    assert first.up.least < LEAST
    assert second.up.ticks == ()
    assert min(line.up.min() for line in first.series) == LEAST
    assert (read_reported(path).parts[0].title, read_reported(path).parts[0].sentences) == ("E", ("words",))


def test_growth_is_drawn_through_its_power_law(path: Path) -> None:
    chart = read_reported(path).charts[2]
    assert (chart.name, chart.against, chart.measure) == ("ms against pixels", "pixels", "ms")
    assert [line.name for line in chart.series] == ["square: exponent 2.00", "flat: exponent 0.00"]
    assert [fit.name for fit in chart.fits] == [line.name for line in chart.series]
    assert chart.fits[0].up == pytest.approx([2e-2, 2e2])
    assert chart.fits[1].up == pytest.approx([5.0, 5.0])
    assert chart.across.least < 1e3 < 1e5 < chart.across.most


def test_contrast_against_noise_has_a_line_for_each_method_and_the_front(path: Path) -> None:
    chart = read_reported(path).charts[3]
    assert chart.name == "contrast against noise"
    assert [line.name for line in chart.fits] == ["a", "b", "Pareto front"]
    assert (chart.fits[0].across.tolist(), chart.fits[0].up.tolist()) == ([1.1, 1.2], [1.5, 2.0])
    assert chart.fits[2].up.tolist() == [1.5, 2.0]
    assert chart.up.least < 1.2 < 2.0 < chart.up.most


@pytest.mark.parametrize("decade", range(-6, 6))
def test_ticks_are_numbers_without_a_power_of_ten_that_say_where_they_are(decade: int) -> None:
    ticks = tuple(digit * 10.0**decade for digit in (1.0, 2.0, 5.0))
    labels = Scale(ticks[0], ticks[-1], ticks).labels
    assert not any(set(label) - set("0123456789.") for label in labels)
    assert [float(label) for label in labels] == pytest.approx(ticks)


def test_the_present_setting_is_found_among_the_points(path: Path) -> None:
    first, second, grown, gained = read_reported(path).charts
    default = EnhanceParams()
    assert current(first, default) == POINTS[0]
    assert current(first, replace(default, subsample=1)) == POINTS[1]
    assert current(first, replace(default, radii=(4, 16))) == POINTS[2]
    assert current(first, replace(default, radii=(5, 16))) is None
    assert current(first, VesselParams()) is None
    assert current(second, default) is None
    assert current(grown, default) is None
    assert current(gained, default) is None


def test_a_report_joins_what_is_open_and_is_drawn(state: AppState, path: Path) -> None:
    clip = state.source.clip
    (opened,) = open_path(OpenRequest(path))
    arriving.show_opened(state, path, opened)
    assert state.source.clip is clip
    assert state.reports.asked
    ui = Ui()
    for place in (0, 1, 2, 3):
        actions.choose_chart(state, place)
        for _ in range(2):
            ui.frame(lambda: draw_report(state, Shown()))
    state.reports.shown = None
    ui.frame(lambda: draw_report(state, Shown()))
    ui.close()


def test_the_page_keeps_its_height_when_the_diagram_is_scrolled_out_of_sight(
    state: AppState, path: Path
) -> None:
    (opened,) = open_path(OpenRequest(path))
    arriving.show_opened(state, path, opened)
    ui, heights = Ui(), []

    def draw(top: float) -> None:
        draw_report(state, Shown())
        imgui.dummy(ImVec2(0, 3000))
        imgui.set_scroll_y(top)
        heights.append(imgui.get_cursor_pos_y())

    for top in (0.0, 1200.0):
        for _ in range(4):
            ui.frame(partial(draw, top))
    ui.close()
    assert heights[-1] == pytest.approx(heights[3], abs=1)  # Rounded with the scrolled position.


def test_another_file_is_refused_in_one_line(tmp_path: Path) -> None:
    other = tmp_path / "cameras.json"
    other.write_text("[1, 2]")
    with pytest.raises(UserError, match="report"):
        list(open_path(OpenRequest(other)))


def test_a_legend_lies_in_the_corner_only_where_no_point_does(path: Path) -> None:
    chart = next(chart for chart in read_reported(path).charts if chart.logarithmic)
    fast = Point(series="subsample", setting="s", seconds=0.0021, error=2 * chart.up.least)
    assert chart.corner_is_free
    assert not replace(chart, points=(*chart.points, fast)).corner_is_free
