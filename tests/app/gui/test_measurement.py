from __future__ import annotations

import numpy as np
import pytest

from app.gui.views.measurement import Located, Measurement

A, B = Located((1.0, 2.0, 50.0)), Located((4.0, 6.0, 50.0))


def test_two_points_are_a_straight_distance_in_the_scene_s_unit() -> None:
    both = Measurement().with_point(A, 0.25).with_point(B, 0.25)
    assert both.distance == pytest.approx(5.0)
    assert both.text("mm") == "5 mm"
    assert both.text("scene units") == "5 units (no scale)"


def test_points_of_two_moments_are_no_distance() -> None:
    one = Measurement().with_point(A, 0.25).with_point(B, 0.5)
    assert one == Measurement((B,), 0.5)
    assert one.text("mm") == ""


def test_a_third_point_begins_anew() -> None:
    assert Measurement((A, B), 0.1).with_point(A, 0.1) == Measurement((A,), 0.1)


def test_points_of_two_surfaces_are_no_distance() -> None:
    assert Measurement().with_point(A, 0.1, "run").with_point(B, 0.1, "other").distance is None


def test_the_error_is_that_of_depths_which_err_by_themselves() -> None:
    """Against many pairs of depths drawn at random."""
    rng = np.random.default_rng(0)
    rays, depths, errors = np.array([[-0.3, 0.1, 1], [0.4, -0.2, 1]]), np.array([60.0, 75.0]), (0.8, 1.5)
    drawn = depths + rng.normal(0, errors, (100_000, 2))
    ends = drawn[..., None] * rays
    expected = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).std()
    located = (
        Located(tuple(depth * ray), tuple(ray), error)
        for depth, ray, error in zip(depths, rays, errors, strict=True)
    )
    first, second = located
    both = Measurement().with_point(first, 0.0).with_point(second, 0.0)
    assert both.error == pytest.approx(expected, rel=0.01)
    assert both.text("mm") == f"{both.distance:.1f} ± {both.error:.1f} mm"
    assert "±" not in both.text("scene units")


@pytest.mark.parametrize(
    ("error", "text"), [(0.004, "0.004"), (0.034, "0.034"), (0.34, "0.34"), (3.4, "3.4"), (34, "34")]
)
def test_the_error_has_two_digits_and_at_most_three_decimals(error: float, text: str) -> None:
    near, far = Located((0, 0, 50.0), (0, 0, 1.0), error), Located((0, 0, 150.0))
    assert f"± {text} mm" in Measurement((near, far)).text("mm")
