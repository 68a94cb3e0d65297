from __future__ import annotations

import numpy as np
import pytest

from app.gui.views.measurement import Located, Measurement

A, B = Located((1.0, 2.0, 50.0)), Located((4.0, 6.0, 50.0))


def test_two_points_are_a_straight_distance_in_the_scene_s_unit() -> None:
    both = Measurement().with_point(A, 0.25).with_point(B, 0.25)
    assert both.length == pytest.approx(5.0)
    assert both.text("mm") == "5 mm"
    assert both.text("scene units") == "5 units (no scale)"


def test_points_of_two_moments_are_no_distance() -> None:
    one = Measurement().with_point(A, 0.25).with_point(B, 0.5)
    assert one == Measurement((B,), 0.5)
    assert one.text("mm") == ""


def test_a_third_point_begins_anew() -> None:
    assert Measurement((A, B), 0.1).with_point(A, 0.1) == Measurement((A,), 0.1)


def test_points_of_two_surfaces_are_no_distance() -> None:
    assert Measurement().with_point(A, 0.1, "run").with_point(B, 0.1, "other").length is None


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
    assert both.length_error == pytest.approx(expected, rel=0.01)
    assert both.text("mm") == f"{both.length:.1f} ± {both.length_error:.1f} mm"
    assert "±" not in both.text("scene units")


@pytest.mark.parametrize(
    ("error", "text"),
    [(0.00004, "0.000040"), (0.004, "0.0040"), (0.034, "0.034"), (0.34, "0.34"), (3.4, "3.4"), (34, "34")],
)
def test_the_error_has_two_digits(error: float, text: str) -> None:
    near, far = Located((0, 0, 50.0), (0, 0, 1.0), error), Located((0, 0, 150.0))
    assert f"± {text} mm" in Measurement((near, far)).text("mm")


LINE = (A, B, Located((4.0, 6.0, 62.0)), Located((1.0, 2.0, 62.0)))


def test_a_line_goes_on_and_its_length_is_that_of_its_sections() -> None:
    line = Measurement()
    for point in LINE[:3]:
        line = line.with_point(point, 0.5, "run", goes_on=True)
    assert line.length == pytest.approx(5 + 12)
    assert line.with_point(A, 0.5, "run") == Measurement((A,), 0.5, "run")
    assert line.with_point(A, 0.6, "run", goes_on=True) == Measurement((A,), 0.6, "run")


def test_a_closed_line_has_a_flat_area_and_a_length_all_around() -> None:
    outline = Measurement(LINE, 0.5, "run").as_outline()
    assert outline.area == pytest.approx(5 * 12)
    assert outline.length == pytest.approx(2 * (5 + 12))
    assert outline.text("mm") == "60 mm² · 34 mm around"
    assert outline.text("scene units") == "60 units² (no scale) · 34 units (no scale) around"
    large = Measurement(
        tuple(Located((100 * x, 100 * y, 100 * z)) for x, y, z in (one.point for one in LINE))
    )
    assert large.as_outline().text("mm") == "600000 mm² · 3400 mm around"
    assert large.text("scene units") == "2200 units (no scale)"
    assert outline.with_point(A, 0.5, "run", goes_on=True) == Measurement((A,), 0.5, "run")
    assert Measurement(LINE[:2]).as_outline() == Measurement(LINE[:2])
    assert Measurement(LINE[:2]).area is None


def test_the_area_of_a_circle_is_approached_from_any_plane_and_origin() -> None:
    turned = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    angles = 2 * np.pi * np.arange(400) / 400
    corners = 7 * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1) @ turned.T + [1e3, -2e3, 5e2]
    outline = Measurement(tuple(Located(tuple(each)) for each in corners.tolist()), closed=True)
    assert outline.area == pytest.approx(np.pi * 49, rel=1e-4)
    assert outline.length == pytest.approx(2 * np.pi * 7, rel=1e-4)


def test_errors_of_lines_and_areas_are_those_of_drawn_depths() -> None:
    rng = np.random.default_rng(2)
    rays = np.array([[-0.3, 0.1, 1], [0.4, -0.2, 1], [0.3, 0.4, 1], [-0.2, 0.5, 1]])
    depths, errors = np.array([60.0, 62.0, 75.0, 70.0]), np.array([0.4, 0.2, 0.6, 0.3])
    drawn = (depths + rng.normal(0, errors, (100_000, 4)))[..., None] * rays
    located = tuple(
        Located(tuple((depth * ray).tolist()), tuple(ray.tolist()), error)
        for depth, ray, error in zip(depths, rays, errors.tolist(), strict=True)
    )
    lines = np.linalg.norm(np.diff(drawn, axis=1), axis=2).sum(axis=1)
    assert Measurement(located).length_error == pytest.approx(lines.std(), rel=0.01)
    around = lines + np.linalg.norm(drawn[:, 0] - drawn[:, -1], axis=1)
    outline = Measurement(located, closed=True)
    assert outline.length_error == pytest.approx(around.std(), rel=0.01)
    ends = np.roll(drawn, -1, axis=1)
    areas = np.linalg.norm(np.cross(drawn, ends).sum(axis=1) / 2, axis=1)
    assert outline.area_error == pytest.approx(areas.std(), rel=0.01)


@pytest.mark.parametrize("points", [(A, A, A), (A, B, A)])
def test_points_that_span_nothing_have_no_area_and_no_error_that_is_no_number(
    points: tuple[Located, ...],
) -> None:
    points = tuple(Located(one.point, (0.1, 0.2, 1.0), 0.5) for one in points)
    outline = Measurement(points, closed=True)
    assert outline.area == 0
    assert outline.area_error == 0
    assert np.isfinite(outline.length_error)
    assert "nan" not in outline.text("mm")
