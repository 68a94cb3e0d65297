from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from app.report.diagrams import Diagram, Point, pareto_front
from app.report.plots import diagrams_figure

NUMBERS = st.floats(0.1, 10)


def diagram(pairs: list[tuple[float, float]], more_is_better: bool = False) -> Diagram:
    points = (
        Point(series="a", setting=str(index), seconds=seconds, error=error)
        for index, (seconds, error) in enumerate(pairs)
    )
    return Diagram(measure="error", points=tuple(points), more_is_better=more_is_better)


@given(st.lists(st.tuples(NUMBERS, NUMBERS), max_size=12))
def test_no_point_beats_one_of_the_front_and_one_of_the_front_beats_any_other(
    pairs: list[tuple[float, float]],
) -> None:
    front = [(point.seconds, point.error) for point in pareto_front(diagram(pairs))]
    assert front == sorted(front)
    for one in front:
        assert not any(s <= one[0] and e <= one[1] and (s, e) != one for s, e in pairs)
    for s, e in pairs:
        assert any(a <= s and b <= e for a, b in front)


def test_more_may_be_better_and_what_was_not_measured_is_on_no_front() -> None:
    pairs = [(1, 20), (2, 30), (3, 25), (4, math.nan)]
    front = pareto_front(diagram(pairs, more_is_better=True))
    assert [point.setting for point in front] == ["0", "1"]


def test_the_picture_has_a_panel_for_each_measure_that_was_taken(tmp_path: Path) -> None:
    taken, none = diagram([(1, 2), (10, 1)]), diagram([(1, math.nan)])
    widths = []
    for index, given_ in enumerate(([taken], [taken, taken], [taken, none])):
        path = tmp_path / f"{index}.png"
        diagrams_figure(given_, "title").savefig(path, dpi=150)
        picture = cv2.imread(str(path))
        assert picture is not None
        assert np.ptp(picture) == 255
        widths.append(picture.shape[1])
    assert widths[1] > widths[0]
    assert widths[2] == widths[0]
