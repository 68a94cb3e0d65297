from __future__ import annotations

import pytest

from app.gui.views.measurement import Measurement

A, B = (1.0, 2.0, 50.0), (4.0, 6.0, 50.0)


def test_two_points_are_a_straight_distance_in_the_scene_s_unit() -> None:
    both = Measurement().with_point(A, 0.25).with_point(B, 0.25)
    assert both.distance == pytest.approx(5.0)
    assert both.text("mm") == "5 mm"
    assert both.text("scene units") == "5 units"


def test_points_of_two_moments_are_no_distance() -> None:
    one = Measurement().with_point(A, 0.25).with_point(B, 0.5)
    assert one == Measurement((B,), 0.5)
    assert one.text("mm") == ""


def test_a_third_point_begins_anew() -> None:
    assert Measurement((A, B), 0.1).with_point(A, 0.1) == Measurement((A,), 0.1)


def test_points_of_two_surfaces_are_no_distance() -> None:
    assert Measurement().with_point(A, 0.1, "run").with_point(B, 0.1, "other").distance is None
