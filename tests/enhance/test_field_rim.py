"""The kernels that look for a field of view against plain numpy."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from enhance import field_circle, field_outline, field_regions, field_rim, field_shape, field_tones
from enhance.field import FieldOfView
from enhance.field_circle import Points
from enhance.field_rim import RAYS, left_along_rays
from enhance.field_search import find_field
from tests.enhance import field_oracle
from tests.enhance.endoscopes import APART, OUTLINES, SEVERAL, found, outline, seen_in
from tests.enhance.pictures import ByteImage, as_type, vessels

DTYPES = (np.uint8, np.uint16, np.float32, np.float64)


def hull(rng: np.random.Generator, height: int, width: int) -> Points:
    """A random convex outline."""
    points = rng.uniform((0, 0), (width, height), (int(rng.integers(4, 30)), 2))
    return np.asarray(cv2.convexHull(points.astype(np.float32))[:, 0], np.float64)


@given(st.integers(0, 9999), st.sampled_from(DTYPES), st.sampled_from([3, 1]), st.integers(1, 6))
def test_rays_leave_the_field_where_numpy_has_it(seed: int, dtype: Any, channels: int, pixel: int) -> None:
    rng = np.random.default_rng(seed)
    height, width = rng.integers(20, 120, 2).tolist()
    values = rng.random((height, width, channels)) ** 2
    corners = hull(rng, height, width)
    cv2.fillConvexPoly(values, (0.9 * corners).astype(np.int32), (0.8, 0.5, 0.4))
    image = as_type(values if channels == 3 else values[..., 0], dtype)
    threshold = float(rng.uniform(5, 60))
    most = threshold + float(rng.uniform(0, 100))
    rim = left_along_rays(image, corners - 0.5, (height, width), threshold, most, pixel)
    points, cropped, lit = field_oracle.rim_of(image, corners, threshold, most, pixel)
    # The threshold of noise is found to a sixteenth of a grey level, so that a few rays of floats may differ.
    off = np.abs(rim.points[:RAYS] - points[:RAYS]).max(axis=1) > 1e-6
    assert np.mean(off) < (1e-9 if dtype == np.uint8 else 0.02)
    if not off.any():
        assert np.allclose(rim.points, points)
        assert np.array_equal(rim.cropped, cropped)
        assert np.array_equal(rim.lit, lit)


@given(st.integers(0, 9999), st.floats(0, 0.4), st.floats(0, 3))
def test_the_circle_is_the_one_that_numpy_finds(seed: int, stray: float, noise: float) -> None:
    rng = np.random.default_rng(seed)
    radius, middle = rng.uniform(20, 900), rng.uniform(-100, 900, 2)
    angles = rng.uniform(0, 2 * np.pi, int(rng.integers(RAYS // 6, RAYS)))
    off = rng.normal(0, noise, len(angles)) + np.where(rng.random(len(angles)) < stray, -30, 0)
    points = middle + (radius + off)[:, None] * np.stack((np.cos(angles), np.sin(angles)), axis=1)
    *circle, share = field_circle.circle_through(points)
    exact, exact_share = field_oracle.circle_of(points)
    assert np.allclose(circle, exact, atol=1e-6)
    assert share == pytest.approx(exact_share, abs=1 / len(points))


@given(st.integers(0, 9999), st.floats(0.3, 1.1), st.floats(0, 2), st.floats(0, 0.6))
def test_a_circle_is_cut_where_numpy_cuts_it(seed: int, depth: float, noise: float, stray: float) -> None:
    rng = np.random.default_rng(seed)
    radius, turn = rng.uniform(20, 900), rng.integers(8) * np.pi / 4
    far = depth * radius / np.maximum(field_rim.ALONG @ (np.cos(turn), np.sin(turn)), 1e-9)
    far = np.minimum(far, radius) + rng.normal(0, noise, RAYS)
    far[rng.random(RAYS) < stray] *= 0.9
    points, lit = far[:, None] * field_rim.ALONG, rng.random(RAYS) < 0.9
    x, y = rng.uniform(0, 900, 2).tolist()
    placed = points + np.array([x, y])
    is_cut, levels = field_shape._straight_levels(placed, lit, x, y, radius)
    points = placed - np.array([x, y])
    assert is_cut == (levels < radius).any()
    assert np.allclose(levels, field_oracle.straight_levels_of(points, lit, radius))
    if depth < 0.9 and noise < 0.3 and stray < 0.1:
        assert levels[round(turn / (np.pi / 4))] == pytest.approx(depth * radius, abs=1)


@given(st.integers(0, 9999), st.sampled_from([3, 4, 8, 40]), st.integers(0, 3))
def test_sides_run_as_numpy_has_them(seed: int, count: int, grid: int) -> None:
    """Also those of frames, octagons, and lines."""
    rng = np.random.default_rng(seed)
    turns = np.linspace(0, 2 * np.pi, count, endpoint=False) + rng.choice([0, np.pi / 8, 0.3])
    flat = rng.choice([1, 0.01, 0.0])
    corners = 60 + rng.uniform(20, 90) * np.stack((np.cos(turns), flat * np.sin(turns)), axis=1)
    corners = (corners + rng.normal(0, 0.1 * grid, corners.shape)).astype(np.float32)
    is_shade, straight, tenths = field_shape._runs_of(corners, 120, 100)
    expected = field_oracle.runs_of(corners.astype(np.float64), 120, 100)
    assert (is_shade, straight) == (expected[0], pytest.approx(expected[1], abs=1e-6))
    assert tenths.tolist() == [[round(value, 1) for value in corner] for corner in corners.tolist()]


@given(st.integers(0, 9999), st.integers(1, 12))
def test_what_lies_beside_a_rim_is_dim_where_numpy_has_it(seed: int, factor: int) -> None:
    rng = np.random.default_rng(seed)
    low = rng.integers(0, 256, rng.integers(16, 90, 2), dtype=np.uint8)
    x, y, radius = (factor * rng.uniform((-20, -20, 1), (110, 110, 90))).tolist()
    beside = low, factor, (x, y, radius), float(rng.uniform(0, 255))
    assert field_rim.dim_beside(*beside) == field_oracle.dim_beside(*beside)


def test_points_on_a_line_lie_on_no_circle_of_the_picture() -> None:
    points = np.stack((np.linspace(3, 90, 60), np.linspace(2, 31, 60)), axis=1)
    points, cropped = np.concatenate((points, [(50.0, 60.0)])), np.zeros(61, bool)
    rim = field_rim.Rim(points, cropped, ~cropped, 0.0, is_noisy=False, is_dark=False)
    assert field_shape.fitted(rim, FieldOfView(100, 80), 0.0).circle is None


@given(st.integers(0, 9999))
def test_tones_and_surroundings_are_those_of_numpy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    height, width = rng.integers(2, 60, 2).tolist()
    low = rng.integers(0, int(rng.integers(2, 257)), (height, width), dtype=np.uint8)
    threshold = float(rng.uniform(0, 120))
    above = low[low > threshold]
    middle = float(np.median(above)) if len(above) else threshold
    assert field_tones.middle_above(field_tones.counts_of(low), threshold) == middle
    field = np.zeros_like(low)
    cv2.fillConvexPoly(field, hull(rng, height, width).astype(np.int32), 1)
    lit = (low > threshold).astype(np.uint8)
    ring = field_oracle.ring_of(field)
    expected = (
        (field == 0).sum(),
        (lit[field == 0] == 0).sum(),
        ring.sum(),
        (low[ring] > threshold + 10).sum(),
    )
    spans = field_outline.spans_in(field)
    assert field_outline.around(low, lit, spans, threshold + 10) == expected


@given(st.integers(0, 9999))
def test_large_parts_are_those_of_opencv(seed: int) -> None:
    rng = np.random.default_rng(seed)
    height, width = rng.integers(2, 40, 2).tolist()
    lit = (rng.random((height, width)) < rng.random()).astype(np.uint8)
    count, labels, facts, _ = cv2.connectedComponentsWithStats(lit, connectivity=4)
    regions = field_regions.connected(lit, 1)
    areas = field_regions.areas_of(regions)
    assert np.array_equal(areas, [0, *facts[1:count, cv2.CC_STAT_AREA]])
    assert np.array_equal(field_regions.drawn(regions, height, width), labels)
    are_large = areas >= field_outline.LEAST_PART * max(areas.max(), 1)
    y, x = np.nonzero(are_large[labels])
    rows = {row: (x[y == row].min(), x[y == row].max()) for row in set(y.tolist())}
    ends = field_regions.ends_of(regions, are_large)
    assert ends.tolist() == [[at, row] for row, both in sorted(rows.items()) for at in both]


@pytest.mark.parametrize("size", [(512, 640), (1024, 1280), (1080, 1920), (2160, 3840)])
def test_a_picture_with_one_dark_corner_reaches_its_border_elsewhere(size: tuple[int, int]) -> None:
    height, width = size
    field = find_field(vessels(height, width))
    assert field is not None
    y, x = np.mgrid[:height, :width]
    within = x + y > 0.2 * height + 0.03 * width
    assert field.mask()[within].all()
    assert not field.mask()[x + y < 0.2 * height - 12].any()


@pytest.mark.parametrize("name", OUTLINES)
def test_a_rough_outline_with_tissue_beyond_it_is_mended(name: str) -> None:
    """The tissue is taken for noise of the surround, but not for more than lies half way to tissue."""
    field = outline(name)
    image: ByteImage = seen_in(field)
    rough = cv2.erode(field.astype(np.uint8), np.ones((9, 9), np.uint8), borderValue=1)
    [contour], _ = cv2.findContours(rough, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    corners = np.asarray(cv2.convexHull(contour)[:, 0], np.float64)
    rim = left_along_rays(image, corners, field.shape, 36.0, 86.0, 4)
    mask = field_shape.fitted(rim, FieldOfView(320, 240), 0.0).mask()
    assert not mask[~field].any()
    assert mask[cv2.erode(field.astype(np.uint8), np.ones((17, 17), np.uint8), borderValue=1) > 0].all()


@pytest.mark.parametrize("name", [*OUTLINES, *APART, *SEVERAL])
def test_a_field_that_is_found_needs_no_check(name: str) -> None:
    field = found(seen_in(outline(name)))
    assert not field.is_whole
    checked = FieldOfView(field.width, field.height, field.circle, field.polygon, field.parts)
    assert repr(checked) == repr(field)
    assert checked == field
