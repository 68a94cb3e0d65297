"""What the search of the field of view makes of a small copy, against OpenCV."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from enhance.field_copy import small_copy
from enhance.field_hull import hull_of, within
from enhance.field_outline import (
    LEAST_FIELD,
    LEAST_PART,
    MOST_SWALLOWED,
    SQUARE,
    around,
    is_convex,
    is_sharp,
    is_surround,
    lit_above,
    spans_in,
)
from enhance.field_regions import (
    Levels,
    Numbers,
    areas_of,
    connected,
    dark_beside_border,
    drawn,
    ends_of,
    lit_parts,
)


def cloudy(rng: np.random.Generator) -> Levels:
    """Blobs of random sizes, or noise."""
    height, width, side = (int(size) for size in rng.integers(1, (60, 60, 9)))
    return np.asarray(cv2.blur(rng.integers(0, 256, (height, width), dtype=np.uint8), (side, side)), np.uint8)


def lit_parts_of_opencv(low: Levels, threshold: float) -> tuple[Levels, Numbers, int]:
    lit = np.asarray(cv2.threshold(low, threshold, 1, cv2.THRESH_BINARY)[1], np.uint8)
    beyond = {"borderType": cv2.BORDER_CONSTANT, "borderValue": (0.0,)}
    count, labels = cv2.connectedComponents(
        cv2.morphologyEx(lit, cv2.MORPH_OPEN, SQUARE, **beyond), connectivity=4
    )
    return lit, np.asarray(labels, np.int32), count


@pytest.mark.parametrize("seed", range(200))
def test_lit_parts_are_those_of_opencv(seed: int) -> None:
    rng = np.random.default_rng(seed)
    low = cloudy(rng)
    for threshold in (float(np.median(low)), float(rng.uniform(0, 255)), 0.0, 255.0, 300.0):
        lit, parts, areas = lit_parts(low, threshold)
        expected, labels, count = lit_parts_of_opencv(low, threshold)
        assert np.array_equal(lit, expected)
        assert np.array_equal(drawn(parts, *low.shape), labels)
        assert np.array_equal(areas, np.bincount(labels[labels > 0], minlength=count))


@pytest.mark.parametrize("seed", range(100))
def test_what_is_dark_beside_the_border_is_what_opencv_floods(seed: int) -> None:
    rng = np.random.default_rng(seed)
    low = cloudy(rng)
    lit, field = (low > np.median(low)).astype(np.uint8), rng.integers(0, 2, low.shape, dtype=np.uint8)
    framed = cv2.copyMakeBorder(lit, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
    cv2.floodFill(framed, None, (0, 0), 2)
    reached = framed[1:-1, 1:-1] == 2
    runs, rows, _ = connected(field, 1)
    assert dark_beside_border(lit, runs, rows) == ((reached & (field > 0)).sum(), reached.sum())
    assert is_convex(lit, field) == ((reached & (field > 0)).sum() <= MOST_SWALLOWED * reached.sum())
    spans = np.sort(rng.integers(0, low.shape[1] + 1, (len(low), 2), dtype=np.int32), axis=1)
    columns = np.arange(low.shape[1])
    inside = (columns >= spans[:, :1]) & (columns < spans[:, 1:])
    rows = np.arange(len(low) + 1, dtype=np.int32)
    assert dark_beside_border(lit, spans, rows) == ((reached & inside).sum(), reached.sum())


@pytest.mark.parametrize("seed", range(200))
def test_the_convex_outline_and_what_lies_within_are_those_of_opencv(seed: int) -> None:
    """Also of single pixels and straight lines."""
    rng = np.random.default_rng(seed)
    low = cloudy(rng) if seed % 3 else np.ascontiguousarray(np.fliplr(np.eye(*rng.integers(1, 40, 2))))
    regions = connected((low > np.quantile(low, rng.uniform(0, 0.9))).astype(np.uint8), 1)
    ends = ends_of(regions, areas_of(regions) > 0)
    if len(ends) == 0:
        return
    expected, field = cv2.convexHull(ends), np.zeros(low.shape, np.uint8)
    cv2.fillConvexPoly(field, expected, 1)
    corners = hull_of(ends)
    # It begins elsewhere.
    [first] = np.flatnonzero((expected[:, 0] == corners[0]).all(axis=1))
    assert np.array_equal(corners, np.roll(expected[:, 0], -first, axis=0))
    spans, columns = within(corners, *low.shape), np.arange(low.shape[1])
    assert np.array_equal(spans, spans_in(field))
    assert np.array_equal((columns >= spans[:, :1]) & (columns < spans[:, 1:]), field > 0)


@pytest.mark.parametrize("seed", range(60))
def test_an_outline_is_what_its_steps_give_in_turn(seed: int) -> None:
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:90, :120]
    bright = np.hypot(x - rng.uniform(0, 120), y - rng.uniform(0, 90)) < rng.uniform(5, 120)
    low = np.where(bright, cv2.resize(cloudy(rng), (120, 90)), rng.integers(0, 12, bright.shape)).astype(
        np.uint8
    )
    lit, outline = lit_above(low, 20.0)
    pixels, parts, areas = lit_parts(low, 20.0)
    assert np.array_equal(lit.pixels, pixels)
    assert np.array_equal(lit.labels, drawn(parts, *low.shape))
    assert lit.count == len(areas)
    area = areas.max()
    ends = ends_of(parts, areas >= LEAST_PART * area)
    assert (outline is None) == (area == 0 or area < LEAST_FIELD * low.size)
    if outline is None:
        return
    field, hull = np.zeros_like(low), cv2.convexHull(ends)
    cv2.fillConvexPoly(field, hull, 1)
    outside, dark, rim, sharp = around(low, pixels, spans_in(field), 30.0)
    is_framed = is_surround(low, outside, dark) and is_sharp(rim, sharp)
    assert sorted(outline.corners.tolist()) == (sorted(hull[:, 0].tolist()) if is_framed else [])


@pytest.mark.parametrize("factor", range(1, 14))
@pytest.mark.parametrize("colors", [(), (3,)])
def test_the_small_copy_is_that_of_opencv(factor: int, colors: tuple[int, ...]) -> None:
    """Also of an image whose sides are not multiples of the factor."""
    rng = np.random.default_rng(factor)
    for right, below in ((0, 0), (0, factor // 2), *rng.integers(0, factor, (9, 2)).tolist()):
        height, width = 20 * factor + below, 31 * factor + right
        image = rng.integers(0, 256, (height, width, *colors), dtype=np.uint8)
        small, low = small_copy(image, factor)
        expected = cv2.resize(image, (31, 20), interpolation=cv2.INTER_LINEAR)
        assert np.array_equal(small, expected)
        assert np.array_equal(low, cv2.medianBlur(expected.max(axis=2) if colors else expected, 3))
