"""What is selected, against its definition: Camera.project in double precision and the winding of lines."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from renderer.camera import Camera
from renderer.editing.regions import Box, Lasso, Range, Rectangle, Region, Sphere, found
from renderer.editing.sight import Sight, Trail, Trait
from renderer.gaussians import DynamicGaussians
from tests.renderer.editing.models import models
from tests.renderer.scenes import turned_camera

TIMES = tuple(np.linspace(0, 1, 5))
TIME, NEAR = 0.4, 1.0


def camera_on(model: DynamicGaussians) -> Camera:
    """Turned, with part of the Gaussians behind it."""
    camera = turned_camera(64, 48, focal=30.0)
    pose = camera.camera_from_world.copy()
    pose[:3, 3] = np.array([0.0, 0.0, 1.5]) - pose[:3, :3] @ np.median(model.means, axis=0)
    return camera.moved(pose)


@pytest.fixture(params=["still", "spline", "flexible", "hexplane"])
def sight(request: pytest.FixtureRequest) -> Sight:
    model = models()[request.param]
    return Sight.of(Trail(model, TIMES), camera_on(model), TIME, NEAR)


def exact(sight: Sight) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pixels (N, 2), depths and positions, in float64."""
    model = sight.trail.model
    means = model.at(TIME).means.astype(np.float64)
    return (*camera_on(model).project(means), means)


def chosen(region: Region, sight: Sight) -> np.ndarray:
    return found(region, sight).booleans()


def test_centres_are_where_the_camera_sees_them(sight: Sight) -> None:
    pixels, depth, _ = exact(sight)
    seen = depth > NEAR
    assert 0 < seen.sum() < len(seen)
    np.testing.assert_allclose(sight.x[seen], pixels[seen, 0], atol=2e-3, rtol=1e-5)
    np.testing.assert_allclose(sight.y[seen], pixels[seen, 1], atol=2e-3, rtol=1e-5)
    np.testing.assert_allclose(sight.depth, depth, atol=1e-5)
    assert np.isnan(sight.x[~seen]).all()


def test_a_rectangle_holds_what_is_before_the_camera(sight: Sight) -> None:
    pixels, depth, _ = exact(sight)
    inside = (pixels > [15.3, 10.1]).all(axis=1) & (pixels < [50.9, 40.7]).all(axis=1) & (depth > NEAR)
    np.testing.assert_array_equal(chosen(Rectangle(15.3, 10.1, 50.9, 40.7), sight), inside)
    assert inside.any()
    everywhere = chosen(Rectangle(-1e30, -1e30, 1e30, 1e30), sight)
    np.testing.assert_array_equal(everywhere, depth > NEAR)


def test_a_lasso_holds_what_openCV_finds_in_its_polygon(sight: Sight) -> None:
    rng = np.random.default_rng(3)
    turns = np.sort(rng.uniform(0, 2 * np.pi, 30))
    reach = rng.uniform(5, 30, 30)
    corners = np.stack([32 + reach * np.cos(turns), 24 + reach * np.sin(turns)], axis=1).astype(np.float32)
    inside = [
        bool(np.isfinite(x)) and cv2.pointPolygonTest(corners, (float(x), float(y)), False) > 0
        for x, y in zip(sight.x, sight.y, strict=True)
    ]
    assert any(inside)
    assert not all(inside)
    lasso = Lasso(tuple((float(x), float(y)) for x, y in corners))
    np.testing.assert_array_equal(chosen(lasso, sight), inside)


def test_a_lasso_round_a_rectangle_is_the_rectangle_and_a_bow_tie_has_two_halves(sight: Sight) -> None:
    square = Lasso(((10.2, 5.3), (50.1, 5.3), (50.1, 40.4), (10.2, 40.4)))
    whole = chosen(square, sight)
    np.testing.assert_array_equal(whole, chosen(Rectangle(10.2, 5.3, 50.1, 40.4), sight))
    tie = chosen(Lasso((square.corners[0], square.corners[2], square.corners[1], square.corners[3])), sight)
    assert (tie <= whole).all()
    assert not chosen(Lasso(square.corners[:2]), sight).any()
    assert not chosen(Lasso(()), sight).any()


def test_spheres_and_boxes_hold_what_is_within_at_this_time(sight: Sight) -> None:
    _, _, means = exact(sight)
    center = tuple(float(value) for value in np.median(means, axis=0))
    away = np.abs(means - center)
    radius = float(np.median(np.linalg.norm(away, axis=1))) * 1.0001
    inside = np.linalg.norm(away, axis=1) < radius
    np.testing.assert_array_equal(chosen(Sphere(center, radius), sight), inside)  # type: ignore[arg-type]
    half = (radius, 0.7 * radius, 0.5 * radius)
    boxed = (away < half).all(axis=1)
    assert boxed.any()
    np.testing.assert_array_equal(chosen(Box(center, half), sight), boxed)  # type: ignore[arg-type]


@pytest.mark.parametrize("trait", ["opacity", "size", "depth", "motion"])
def test_ranges_part_the_model(sight: Sight, trait: Trait) -> None:
    values = sight.trait(trait)
    middle = float(np.median(values))
    low = chosen(Range(trait, -1e30, middle), sight)
    high = chosen(Range(trait, float(np.nextafter(np.float32(middle), np.float32(np.inf))), 1e30), sight)
    np.testing.assert_array_equal(low, ~high)
    np.testing.assert_array_equal(low, values <= np.float32(middle))


def test_motion_is_the_largest_distance_from_the_first_place() -> None:
    for kind, model in models().items():
        ways = np.stack([model.at(time).means for time in TIMES]).astype(np.float64)
        expected = np.linalg.norm(ways - ways[0], axis=2).max(axis=0)
        amplitudes = Trail(model, TIMES).amplitudes
        np.testing.assert_allclose(amplitudes, expected, atol=1e-5)
        assert (amplitudes > 0).any() == (kind != "still")


def test_a_model_without_gaussians_has_nothing_to_find() -> None:
    model = models()["spline"].rows(np.zeros(0, np.int64))
    sight = Sight.of(Trail(model, TIMES), turned_camera(64, 48), TIME, NEAR)
    regions = (
        Rectangle(0, 0, 9, 9),
        Lasso(((0, 0), (1, 0), (0, 1))),
        Range("motion", 0, 1),
        Sphere((0, 0, 0), 1),
    )
    for region in regions:
        assert len(found(region, sight)) == 0
