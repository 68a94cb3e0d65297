from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from enhance import (
    EnhanceParams,
    ImageError,
    VesselParams,
    enhance,
    enhance_vessels,
    find_field,
    measure,
)
from enhance.image import Picture
from tests.enhance.pictures import DTYPES, as_type, vessels

WRONG: Any = {"z": 0.1}
NONE: Any = None
PAPER: Any = EnhanceParams()
VESSEL: Any = VesselParams()
THREE: Any = 3
GOOD = np.full((4, 5, 3), 0.5, dtype=np.float32)


class Tensor:
    """Of another library, as one that records gradients."""

    def __array__(self, dtype: object = None, copy: object = None) -> NDArray[Any]:
        raise RuntimeError("detach it first")


def changed(value: float) -> NDArray[np.float32]:
    image = GOOD.copy()
    image[2, 3, 1] = value
    return image


@pytest.mark.parametrize(
    ("image", "says"),
    [
        (np.zeros((0, 5), np.uint8), r"at least one pixel.*\(0, 5\)"),
        (np.zeros((5, 0, 3), np.uint8), "at least one pixel"),
        (np.zeros(5, np.uint8), r"\(H, W\).*got \(5,\)"),
        (np.zeros((2, 4, 5, 3), np.uint8), r"got \(2, 4, 5, 3\)"),
        (np.zeros((4, 5, 2), np.uint8), r"got \(4, 5, 2\)"),
        (np.zeros((4, 5, 1), np.uint8), r"got \(4, 5, 1\)"),
        (np.zeros((4, 5), np.int32), "uint8, uint16 or float.*int32"),
        (np.zeros((4, 5), bool), "got bool"),
        (np.zeros((4, 5), complex), "got complex128"),
        (changed(np.nan), "NaN, got 1 of 60 values.* row 2, column 3, channel 1 "),
        (np.where(np.eye(4, 5, 3) > 0, np.nan, np.float32(0)), r"got 2 of 20 values.* row 0, column 3 \("),
        (changed(np.inf), "to inf"),
        (changed(-np.inf), "-inf to"),
        (changed(1.5), "0.5 to 1.5"),
        (changed(-0.25), "-0.25 to 0.5"),
        (changed(1.0000001), "0.5 to 1.0000001"),
        (np.ma.masked_greater(GOOD, 0.4), "expected an image without a mask of its own"),
        (Tensor(), "expected an image that numpy can read, got Tensor"),
        ([[0.1, 0.2], [0.3]], "expected an image that numpy can read, got list"),
        ("frame.png", "expected an image as an array of numbers, got str"),
        (None, "expected an image as an array of numbers, got NoneType"),
    ],
)
def test_bad_images_are_refused_with_a_reason(image: NDArray[Any], says: str) -> None:
    with pytest.raises(ImageError, match=says):
        enhance(image)


@pytest.mark.parametrize(
    ("mask", "says"),
    [
        (np.ones((5, 4), bool), r"shape \(4, 5\).*\(5, 4\)"),
        (np.ones((4, 5, 3), bool), r"\(4, 5, 3\)"),
        (np.ones((4, 5), np.float32), "float32"),
        (np.zeros((4, 5), bool), "at least one pixel to measure"),
        (np.ma.masked_equal(np.ones((4, 5), np.uint8), 0), "expected a tissue_mask without a mask"),
    ],
)
def test_bad_masks_are_refused_with_a_reason(mask: NDArray[Any], says: str) -> None:
    with pytest.raises(ImageError, match=says):
        enhance(GOOD, tissue_mask=mask)


def test_every_type_gives_the_same_picture() -> None:
    values = vessels(40, 50) / 255
    expected = enhance(values).image
    for dtype in DTYPES:
        image = as_type(values, dtype)
        result = enhance(image).image
        assert result.dtype == image.dtype
        full = np.iinfo(image.dtype).max if image.dtype.kind == "u" else 1
        # The quarter-power of Eq 1 magnifies float16's rounding of dark pixels.
        error = np.abs(result / full - expected)
        assert error.max() < (0.01 if dtype == np.float16 else 0.6 / 255)


@pytest.mark.parametrize("dtype", [">f4", ">f8", ">f2", ">u2"])
def test_either_byte_order_gives_the_same_picture(dtype: str) -> None:
    values = np.where(np.hypot(*np.mgrid[-60:60, -80:80]) < 55, vessels(120, 160)[..., 0] / 255, 0.02)
    full = 65535 if dtype == ">u2" else 1
    other = (values * full).astype(dtype)
    own = other.astype(other.dtype.newbyteorder("="))
    result = enhance(other)
    assert result.image.dtype == own.dtype
    assert np.array_equal(result.image, enhance(own).image)
    assert find_field(other) == find_field(own)


@pytest.mark.parametrize("pixels", ["bogus", "tissue", None, 3])
def test_other_pixels_are_refused(pixels: Any) -> None:
    with pytest.raises(ImageError, match="expected pixels to be 'automatic', 'all' or a FieldOfView, got"):
        enhance(GOOD, pixels=pixels)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: enhance(GOOD, WRONG), "expected params to be EnhanceParams, got dict"),
        (lambda: enhance(GOOD, NONE), "EnhanceParams, got NoneType"),
        (lambda: enhance(GOOD, VESSEL), "EnhanceParams, got VesselParams"),
        (lambda: enhance_vessels(GOOD, PAPER), "VesselParams, got EnhanceParams"),
        (lambda: enhance(GOOD, statistics=THREE), "expected statistics to be Statistics, got int"),
        (lambda: enhance_vessels(GOOD, statistics=THREE), "expected statistics to be Statistics, got int"),
        (lambda: measure([GOOD], VESSEL), "EnhanceParams, got VesselParams"),
    ],
)
def test_arguments_of_another_class_are_refused(call: Callable[[], object], says: str) -> None:
    with pytest.raises(TypeError, match=says):
        call()


@pytest.mark.parametrize("image", [GOOD, GOOD[..., 0], np.dstack((GOOD, GOOD[..., 0]))])
def test_one_image_is_no_clip(image: NDArray[Any]) -> None:
    with pytest.raises(ImageError, match=r"expected several images, got one of shape \(4, 5"):
        measure(image)
    assert measure(image[None]) == measure([image])


def test_alpha_passes_through_and_hides_pixels_from_the_statistics() -> None:
    color = vessels(40, 50)
    alpha = np.full((40, 50), 255, np.uint8)
    alpha[:, 25:] = 0
    result = enhance(np.dstack((color, alpha)))
    assert np.array_equal(result.image[..., 3], alpha)
    assert np.array_equal(result.image[:, 25:, :3], color[:, 25:])
    masked = enhance(color, tissue_mask=alpha > 0).statistics
    # Windows that reach over the rim see other pixels there, so that the deviation of Q moves a little.
    own = replace(result.statistics, sigmas=())
    assert own == replace(masked, sigmas=()) != replace(enhance(color).statistics, sigmas=())
    with pytest.raises(ImageError, match="hides all"):
        enhance(np.dstack((color, np.zeros_like(alpha))))


def test_hidden_pixels_too_far_from_visible_ones_are_black(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(np, "empty", lambda shape, dtype: np.full(shape, 7, dtype))
    alpha = np.zeros((2, 70_000), np.uint8)
    alpha[:, 0] = 255
    filled = Picture(np.full((2, 70_000, 3), 9, np.uint8), alpha).filled.pixels
    assert (filled[:, :60_000] == 9).all()
    assert not filled[:, 69_000:].any()


def test_views_are_read_and_never_written() -> None:
    wide = np.repeat(np.repeat(vessels(40, 50), 2, axis=0), 3, axis=1)
    view = wide[::-2, ::3][:, ::-1]
    before = wide.copy()
    wide.flags.writeable = False
    expected = enhance(np.ascontiguousarray(view)).image
    result = enhance(view).image
    assert np.array_equal(result, expected)
    assert np.array_equal(wide, before)
    assert result.flags.writeable
    assert not np.shares_memory(result, wide)


def test_nothing_aliases_the_input_even_when_nothing_changes() -> None:
    image = vessels(20, 30).astype(np.float32) / np.float32(255)
    identity = EnhanceParams(z=1.0, p=0.0, d_factor=0.0)
    for view in (image, image[..., 0]):
        result = enhance(view, identity).image
        assert not np.shares_memory(result, image)
        np.testing.assert_allclose(result, view, atol=2e-7)
