from __future__ import annotations

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from enhance.field import FieldOfView, overlap, typical, uncovered
from enhance.field_search import find_field
from tests.enhance.endoscopes import (
    APART,
    OUTLINES,
    SEVERAL,
    TOUCHING,
    agreement,
    assert_found,
    found,
    labelled,
    outline,
    seen_in,
)
from tests.enhance.pictures import as_type

PART = FieldOfView(8, 8, circle=(2.0, 2.0, 1.0))


@pytest.mark.parametrize("name", OUTLINES)
@pytest.mark.parametrize(("black", "noise"), [(0, 0), (3, 1), (3, 4), (18, 2), (40, 1)])
def test_an_outline_is_found_in_any_surround(name: str, black: float, noise: float) -> None:
    field = outline(name)
    mask = found(seen_in(field, black=black, noise=noise)).mask()
    assert_found(mask, field)


@pytest.mark.parametrize("name", OUTLINES)
def test_text_and_boxes_in_the_surround_are_none_of_the_field(name: str) -> None:
    field = outline(name)
    mask = found(labelled(seen_in(field))).mask()
    assert_found(mask, field)


@pytest.mark.parametrize("name", ["circle", "beside the middle"])
def test_tissue_that_grows_dark_towards_the_rim_is_field(name: str) -> None:
    field = outline(name)
    assert_found(found(seen_in(field, dim=0.6)).mask(), field, 8)


@pytest.mark.parametrize("size", [(120, 160), (480, 640), (1080, 1920), (231, 317)])
def test_pictures_of_any_size(size: tuple[int, int]) -> None:
    field = outline("circle", *size)
    assert_found(found(seen_in(field)).mask(), field)


@pytest.mark.parametrize("dtype", [np.uint16, np.float16, np.float32, np.float64, np.longdouble])
def test_every_type_of_image_has_the_same_field(dtype: type) -> None:
    image = seen_in(outline("cropped circle"))
    assert overlap(found(as_type(image / 255, dtype)), found(image)) > 0.999


def test_grey_pictures_have_one_too() -> None:
    field = outline("circle")
    assert_found(found(seen_in(field)[..., 0]).mask(), field)


@pytest.mark.parametrize("level", [0, 1, 3, 200, 255])
def test_a_picture_of_one_tone_has_no_surround(level: int) -> None:
    field = find_field(np.full((60, 80, 3), level, np.uint8))
    assert field is None or field.is_whole
    assert (field is None) == (level < 10)


@pytest.mark.parametrize("name", ["circle", "beside the middle"])
def test_a_field_that_a_dark_tool_divides_is_one(name: str) -> None:
    field = outline(name)
    image = seen_in(field)
    image[:, 160:176] = 3
    assert_found(found(image).mask(), field)


@pytest.mark.parametrize("radius", [50, 65])
@pytest.mark.parametrize("share", [0.6, 1.0])
def test_of_two_round_fields_none_is_left_out(radius: int, share: float) -> None:
    y, x = np.mgrid[:240, :320] + 0.5
    fields = (np.hypot(x - 80, y - 120) < radius) | (np.hypot(x - 240, y - 120) < share * radius)
    field = found(seen_in(fields))
    assert_found(field.mask(), fields)
    assert all(one.circle is not None for one in field.parts or ())


@pytest.mark.parametrize("name", APART)
@pytest.mark.parametrize(("black", "noise"), [(0, 0), (3, 4), (18, 2)])
def test_fields_beside_each_other_are_found_each(name: str, black: float, noise: float) -> None:
    fields = outline(name)
    field = found(labelled(seen_in(fields, black=black, noise=noise)))
    assert_found(field.mask(), fields)
    assert len(field.parts or ()) == cv2.connectedComponents(fields.astype(np.uint8))[0] - 1


@pytest.mark.parametrize("name", TOUCHING)
@pytest.mark.parametrize(("black", "noise"), [(0, 0), (3, 4), (18, 2)])
@pytest.mark.parametrize("size", [(240, 320), (540, 960)])
def test_round_fields_that_touch_are_found_each(
    name: str, black: float, noise: float, size: tuple[int, int]
) -> None:
    fields = outline(name, *size)
    field = found(labelled(seen_in(fields, black=black, noise=noise)))
    mask = field.mask()
    assert not mask[~fields].any()
    assert agreement(mask, fields) > 0.93
    assert len(field.parts or ()) == 2
    assert overlap(field, field) == 1


@pytest.mark.parametrize("name", SEVERAL)
@pytest.mark.parametrize(("black", "noise"), [(0, 0), (3, 4), (18, 2)])
@pytest.mark.parametrize("size", [(240, 320), (540, 960)])
def test_several_round_fields_that_touch_are_found_each(
    name: str, black: float, noise: float, size: tuple[int, int]
) -> None:
    fields = outline(name, *size)
    field = found(labelled(seen_in(fields, black=black, noise=noise)))
    assert_found(field.mask(), fields)
    assert [one.circle is not None for one in field.parts or ()] == [True] * len(SEVERAL[name])


@pytest.mark.parametrize("width", [10, 20])
def test_a_round_field_between_the_tips_of_two_dark_tools_is_one(width: int) -> None:
    field = outline("circle")
    y, x = np.mgrid[:240, :320] + 0.5
    image = seen_in(field & ((abs(x - 160) > width) | (abs(y - 120) < 20)))
    assert_found(found(image).mask(), field)


INSET = np.s_[150:198, 252:308]


@pytest.mark.parametrize(("kind", "is_field"), [("tissue", True), ("grey", False), ("even", False)])
def test_a_small_inset_is_field_where_it_looks_as_the_large_one_does(kind: str, is_field: bool) -> None:
    """Such as an overview, not a menu or an image of another kind."""
    y, x = np.mgrid[:240, :320] + 0.5
    field = np.hypot(x - 120, y - 120) < 108
    image = labelled(seen_in(field))
    inset = seen_in(np.ones((48, 56), bool), seed=5)
    image[INSET] = {"tissue": inset, "grey": inset.mean(axis=2, keepdims=True), "even": (200, 110, 95)}[kind]
    field[INSET] = is_field
    assert_found(found(image).mask(), field)


@pytest.mark.parametrize("size", [(240, 320), (720, 1280)])
@pytest.mark.parametrize("turn", [0, 1, 2, 3])
@pytest.mark.parametrize(("fade", "is_field"), [(0.0008, False), (0.006, True), (0.02, True)])
def test_an_arc_of_shade_is_tissue_and_one_with_a_sharp_end_is_surround(
    size: tuple[int, int], turn: int, fade: float, is_field: bool
) -> None:
    """A shadow fades within more of the width of the image than the rim of a field is blurred."""
    height, width = size
    y, x = np.mgrid[:height, :width] + 0.5
    away = np.hypot(x - 0.2 * width, y - height / 2) / width - 0.58
    lit = 0.01 + 0.99 / (1 + np.exp(away / fade))
    image = np.rot90((seen_in(np.ones(size, bool)) * lit[..., None]).astype(np.uint8), turn)
    field = found(image)
    assert field.is_whole == is_field
    if not is_field:
        assert_found(field.mask(), np.rot90(away < 0, turn), 8 * width // 320)


@given(st.lists(st.tuples(st.floats(0, 60), st.floats(0, 50), st.floats(1, 40)), min_size=2, max_size=4))
def test_the_overlap_of_parts_that_share_pixels_is_that_of_the_masks(
    circles: list[tuple[float, float, float]],
) -> None:
    parts = tuple(FieldOfView(60, 50, circle=circle) for circle in circles)
    field, other = FieldOfView(60, 50, parts=parts), FieldOfView(60, 50, circle=(30.0, 20.0, 15.0))
    assert overlap(field, other) == agreement(field.mask(), other.mask())


@pytest.mark.parametrize("turn", [0, 1, 2, 3])
@pytest.mark.parametrize("depth", [0.5, 0.7, 0.9])
@pytest.mark.parametrize("dim", [0.0, 0.5])
def test_a_straight_side_cuts_a_circle(turn: int, depth: float, dim: float) -> None:
    y, x = np.mgrid[:320, :320] + 0.5
    field = np.rot90((np.hypot(x - 160, y - 160) < 140) & (x - 160 < depth * 140), turn)
    assert_found(found(seen_in(field, dim=dim)).mask(), field)


@pytest.mark.parametrize("name", ["circle", "octagon"])
@pytest.mark.parametrize("level", [14, 20, 26, 32])
@pytest.mark.parametrize("blur", [0, 6])
def test_tissue_in_the_shade_is_field(name: str, level: float, blur: float) -> None:
    """Darker than stray light may be, but ending as sharply as what is lit."""
    field = outline(name)
    rng = np.random.default_rng(0)
    tissue = np.where(np.arange(320) < 180, 170.0, level) * np.ones((240, 1))
    tissue = cv2.GaussianBlur(tissue, (0, 0), blur) if blur else tissue
    image = np.where(field, tissue, 2) + rng.integers(-1, 2, field.shape)
    assert_found(found(image.astype(np.uint8)).mask(), field)


@pytest.mark.parametrize("name", ["circle", "beside the middle"])
@pytest.mark.parametrize("black", [3, 18])
def test_a_dark_lumen_beside_the_rim_is_field(name: str, black: float) -> None:
    field = outline(name)
    y, x = np.mgrid[:240, :320] + 0.5
    image = seen_in(field & (np.hypot(x - 250, y - 120) > 60), black=black)
    assert_found(found(image).mask(), field)


@pytest.mark.parametrize("width", [16, 48, 90])
@pytest.mark.parametrize("tilt", [0.2, 0.6])
def test_a_dark_tool_across_the_picture_is_no_surround(width: int, tilt: float) -> None:
    y, x = np.mgrid[:240, :320] + 0.5
    image = seen_in(abs(x + tilt * (y - 120) - 150) > width / 2)
    assert found(image).is_whole


@pytest.mark.parametrize("tilt", [-0.3, 0.2, 0.6, 3.0])
@pytest.mark.parametrize("blur", [0.8, 4])
def test_a_dark_half_with_a_slanting_edge_is_field(tilt: float, blur: float) -> None:
    """Such as the shadow of an instrument, or a drape."""
    y, x = np.mgrid[:240, :320] + 0.5
    lit = cv2.GaussianBlur((x + tilt * (y - 120) > 150).astype(np.float64), (0, 0), blur)
    noise = np.random.default_rng(0).normal(0, 1, (240, 320))
    assert found((5 + lit * 160 + noise).astype(np.uint8)).is_whole


@pytest.mark.parametrize("name", ["left", "top", "diagonal", "half an octagon"])
def test_bars_and_octagons_that_reach_out_of_the_picture_are_surround(name: str) -> None:
    y, x = np.mgrid[:240, :320] + 0.5
    half = (x > 60) & (x - np.abs(y - 120) > -10)
    field = {"left": x > 80, "top": y > 60, "diagonal": x + y > 220, "half an octagon": half}[name]
    assert agreement(found(seen_in(field)).mask(), field) > 0.98


@pytest.mark.parametrize("most", [15, 25, 33])
@pytest.mark.parametrize("width", [8, 16, 40, 1000])
def test_stray_light_on_one_side_is_none_of_the_field(most: float, width: float) -> None:
    y, x = np.mgrid[:240, :320] + 0.5
    away = np.hypot(x - 160, y - 120) - 100
    stray = most * np.exp(-np.maximum(away, 0) / width) * np.clip((x - 160) / 100, 0, 1)
    image = np.where(away < 0, 170, 2 + stray).astype(np.uint8)
    assert_found(found(image).mask(), away < 0)


def test_noise_alone_has_none() -> None:
    rng = np.random.default_rng(1)
    for low, high in ((0, 4), (0, 256), (0, 40)):
        field = find_field(rng.integers(low, high, (120, 160, 3), dtype=np.uint8))
        assert field is None or field.is_whole


def test_a_picture_without_surround_is_all_field() -> None:
    y, x = np.mgrid[:240, :320]
    whole = np.ones((240, 320), bool)
    shading = np.clip(1.2 - np.hypot(x - 160, y - 120) / 170, 0.05, 1)[..., None]
    assert found(seen_in(whole)).is_whole
    assert found((seen_in(whole) * shading).astype(np.uint8)).is_whole


def test_one_pixel_of_tissue_is_too_little_to_tell() -> None:
    image = np.zeros((60, 80, 3), np.uint8)
    image[30, 40] = 200
    assert find_field(image) is None


@pytest.mark.parametrize("shape", [(1, 1), (1, 60), (60, 1), (2, 3), (5, 5)])
def test_tiny_pictures_are_looked_at_without_complaint(shape: tuple[int, int]) -> None:
    for level in (0, 120):
        field = find_field(np.full((*shape, 3), level, np.uint8))
        assert field is None or field.is_whole


@given(
    st.tuples(st.floats(-40, 120), st.floats(-40, 120), st.floats(0, 150)),
    st.integers(1, 70),
    st.integers(1, 90),
)
def test_spans_are_the_pixels_whose_middle_lies_in_the_circle(
    circle: tuple[float, float, float], height: int, width: int
) -> None:
    field = FieldOfView(width, height, circle=circle)
    y, x = np.mgrid[:height, :width] + 0.5
    away = np.hypot(x - circle[0], y - circle[1]) - circle[2]
    sure = np.abs(away) > 1e-6
    assert np.array_equal(field.mask()[sure], (away < 0)[sure])
    columns, spans = np.arange(width), field.spans()
    assert np.array_equal((columns >= spans[:, :1]) & (columns < spans[:, 1:]), field.mask())


@given(st.integers(3, 12), st.floats(5, 60), st.floats(0, 6), st.floats(-20, 90), st.floats(-20, 90))
def test_spans_are_the_pixels_whose_middle_lies_in_the_polygon(
    count: int, radius: float, turn: float, x0: float, y0: float
) -> None:
    angles = turn + np.arange(count) * 2 * np.pi / count
    corners = np.stack((x0 + radius * np.cos(angles), y0 + radius * np.sin(angles)), axis=1)
    field = FieldOfView(70, 60, polygon=tuple((float(a), float(b)) for a, b in corners))
    y, x = np.mgrid[:60, :70] + 0.5
    sides = []
    for (ax, ay), (bx, by) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        sides.append((bx - ax) * (y - ay) - (by - ay) * (x - ax))
    nearest = np.min(sides, axis=0)
    sure = np.abs(nearest) > 1e-6
    assert np.array_equal(field.mask()[sure], (nearest > 0)[sure])


def test_overlap_and_what_is_not_covered_are_those_of_the_masks() -> None:
    one, other = FieldOfView(80, 60, circle=(40, 30, 25)), FieldOfView(80, 60, circle=(50, 30, 20))
    whole = FieldOfView(80, 60)
    assert overlap(one, one) == 1
    assert overlap(one, other) == overlap(other, one) == agreement(one.mask(), other.mask())
    assert overlap(one, whole) == one.mask().mean()
    assert overlap(one, FieldOfView(80, 60, circle=(-90, -90, 5))) == 0
    assert uncovered(one, other) == (one.mask() & ~other.mask()).sum() / one.mask().sum()
    assert uncovered(one, whole) == uncovered(FieldOfView(80, 60, circle=(-90, -90, 5)), one) == 0


@pytest.mark.parametrize("name", APART)
def test_parts_are_spanned_inset_and_compared_together(name: str) -> None:
    field, other = found(seen_in(outline(name))), FieldOfView(320, 240, circle=(100, 110, 80))
    mask, spans, columns = field.mask(), field.spans(), np.arange(320)
    assert overlap(field, other) == overlap(other, field) == agreement(mask, other.mask())
    assert overlap(field, field) == 1
    assert field.parts is not None
    assert np.array_equal(mask, np.any([one.mask() for one in field.parts], axis=0))
    for row, (first, end) in enumerate(spans.tolist()):
        within = columns[mask[row]]
        assert (first, end) == (within[0], within[-1] + 1) if len(within) else first == end
    assert field.inset(3).parts == tuple(one.inset(3) for one in field.parts)


def test_the_typical_field_of_a_clip_is_not_that_of_its_flashes() -> None:
    usual = [FieldOfView(80, 60, circle=(40, 30, 25 + 0.1 * step)) for step in range(5)]
    odd = [FieldOfView(80, 60), FieldOfView(80, 60, circle=(40, 30, 4)), FieldOfView(8, 6)]
    assert typical([*odd, *usual]) in usual


@pytest.mark.parametrize("name", OUTLINES)
@pytest.mark.parametrize("by", [3.0, 9.0])
def test_an_inset_is_the_field_without_its_rim(name: str, by: float) -> None:
    """As erosion leaves it, but for pixels cut by its outline; along the picture's border nothing is lost."""
    field = found(seen_in(outline(name), black=3, noise=1))
    mask, side = field.mask(), 2 * int(by) + 1
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
    eroded = cv2.erode(mask.astype(np.uint8), kernel, borderType=cv2.BORDER_CONSTANT, borderValue=(1.0,)) > 0
    inset = field.inset(by).mask()
    assert not inset[~mask].any()
    assert eroded.sum() < mask.sum()
    assert np.count_nonzero(inset != eroded) < 0.1 * np.count_nonzero(mask != eroded)
    assert len(field.inset(by).polygon or ()) <= len(field.polygon or ())


def test_an_inset_that_leaves_nothing_is_not_made() -> None:
    whole = FieldOfView(width=64, height=48)
    for field in (
        whole,
        replace(whole, circle=(32.0, 24.0, 10.0)),
        replace(whole, polygon=((22.0, 14.0), (42.0, 14.0), (32.0, 34.0))),
    ):
        assert field.inset(20.0) == field


@pytest.mark.parametrize(
    "wrong",
    [
        {"width": 0},
        {"height": -3},
        {"circle": (np.nan, 5.0, 3.0)},
        {"circle": (5.0, 5.0, -1.0)},
        {"polygon": ((0.0, 0.0), (5.0, 5.0))},
        {"polygon": ((0.0, 0.0), (5.0, 5.0), (0.0, np.inf))},
        {"circle": (5.0, 5.0, 3.0), "polygon": ((0.0, 0.0), (5.0, 5.0), (0.0, 5.0))},
        {"polygon": ((0.0, 0.0), (8.0, 0.0), (4.0, 3.0), (8.0, 8.0), (0.0, 8.0))},
        {"polygon": ((0.0, 0.0), (8.0, 8.0), (8.0, 0.0), (0.0, 8.0))},
        {"parts": (PART,)},
        {"parts": (PART, PART), "circle": (5.0, 5.0, 3.0)},
        {"parts": (PART, FieldOfView(8, 8))},
        {"parts": (PART, FieldOfView(9, 8, circle=(5.0, 5.0, 3.0)))},
        {"parts": (PART, FieldOfView(8, 8, parts=(PART, PART)))},
    ],
)
def test_what_is_no_field_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        FieldOfView(**{"width": 8, "height": 8, **wrong})
