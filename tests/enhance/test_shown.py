"""What lies outside the field of view is passed through and counts nowhere."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from enhance import (
    EnhanceParams,
    Enhancer,
    ImageError,
    VesselEnhancer,
    VesselParams,
    enhance,
    enhance_vessels,
    measure,
    shown,
)
from enhance.field import EVERYWHERE, FieldOfView
from enhance.field_search import find_field
from enhance.image import full_scale
from enhance.reference import enhance_reference
from enhance.shown import ALL_KEPT
from enhance.vessel_density import middle_density
from tests.enhance.endoscopes import outline, seen_in
from tests.enhance.pictures import ByteImage, as_type

ROUND = outline("circle", 120, 160)
IMAGE = seen_in(ROUND)
APART = seen_in(outline("two circles", 120, 160))
FIELD = FieldOfView(160, 120, circle=(80.0, 60.0, 52.0))
TYPES = (np.uint8, np.uint16, np.float16, np.float32, np.float64)


@pytest.mark.parametrize("run", [enhance, enhance_vessels])
@pytest.mark.parametrize("dtype", TYPES)
@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize("seen", [IMAGE, APART], ids=["round", "apart"])
def test_outside_stays_bit_for_bit(run: Any, dtype: Any, channels: int, seen: ByteImage) -> None:
    image = as_type(seen / 255, dtype)
    if channels == 1:
        image = image[..., 0]
    elif channels == 4:
        image = np.dstack((image, np.full(image.shape[:2], full_scale(image.dtype), image.dtype)))
    result = run(image)
    field = result.statistics.field
    assert field is not None
    inside = field.mask()
    assert 0.2 < inside.mean() < 0.8
    assert np.array_equal(result.image[~inside], image[~inside])
    assert not np.array_equal(result.image[inside], image[inside])


@pytest.mark.parametrize("run", [enhance, enhance_vessels])
def test_statistics_are_of_the_field(run: Any) -> None:
    masked = run(IMAGE, tissue_mask=FIELD.mask(), pixels="all")
    found = run(IMAGE, pixels=FIELD)
    # Noise of colour is sampled: a mask and a field leave out other samples at the rim.
    own, other = (replace(each.statistics, chroma_snr=None, color_noise=None) for each in (found, masked))
    assert replace(own, field=None) == other
    other = IMAGE.copy()
    other[~outline("cropped circle", 120, 160)] = 255
    used = run(other, pixels=FIELD).statistics
    # Windows that reach over the rim see the surround, so that the deviation of Q moves a little.
    assert replace(used, sigmas=(), p=()) == replace(found.statistics, sigmas=(), p=())


@pytest.mark.parametrize("seen", [IMAGE, APART], ids=["round", "apart"])
def test_within_the_field_the_equations_hold(seen: ByteImage) -> None:
    params = EnhanceParams(omit_below=0.0)
    image, field = seen / 255, find_field(seen)
    assert field is not None
    result = enhance(image, params, pixels=field)
    exact, used = enhance_reference(image, params, pixels=field)
    assert used.level == result.statistics.level
    assert 255 * np.abs(result.image - exact).max() < 0.005


@pytest.mark.parametrize("run", [enhance, enhance_vessels])
def test_what_lies_between_parts_counts_for_nothing(run: Any) -> None:
    field, other = find_field(APART), APART.copy()
    assert field is not None
    other[100:, 76:84] = 255
    masked = run(APART, pixels=field, tissue_mask=outline("two circles", 120, 160)).statistics
    used = [run(image, pixels=field).statistics for image in (APART, other)]
    assert masked == used[0]
    assert replace(used[0], sigmas=(), p=()) == replace(used[1], sigmas=(), p=())


@pytest.mark.parametrize("run", [enhance, enhance_vessels])
def test_a_picture_without_surround_is_as_all_pixels_are(run: Any) -> None:
    image = seen_in(np.ones((120, 160), bool))
    found = find_field(image)
    assert found is not None
    assert found.is_whole
    assert np.array_equal(run(image).image, run(image, pixels="all").image)


def test_statistics_of_a_clip_bring_its_field() -> None:
    images = [seen_in(ROUND, seed=seed) for seed in range(4)]
    pooled = measure(images)
    assert pooled.field is not None
    inside = pooled.field.mask()
    assert not inside[~ROUND].any()
    flash = np.full((120, 160, 3), 255, np.uint8)
    result = enhance(flash, statistics=pooled)
    assert result.statistics.field == pooled.field
    assert np.array_equal(result.image[~inside], flash[~inside])
    assert measure(images, pixels="all").field is None
    assert enhance(images[0], statistics=measure(images, pixels="all")).statistics.field is None


def test_statistics_of_another_size_leave_the_field_to_be_found() -> None:
    pooled = measure([seen_in(outline("circle", 240, 320))])
    used = enhance(IMAGE, statistics=pooled).statistics
    assert pooled.field is not None
    assert pooled.field.width == 320
    assert used.level == pooled.level


@pytest.mark.parametrize(
    ("enhancer", "looks"),
    [
        (Enhancer(), [EnhanceParams(d_factor=d) for d in (0.4, 0.5, 0.6)]),
        (VesselEnhancer(), [VesselParams(strength=strength) for strength in (1.0, 2.0, 3.0)]),
    ],
    ids=["paper", "vessel"],
)
def test_a_moved_slider_does_not_look_for_the_field_again(
    monkeypatch: pytest.MonkeyPatch, enhancer: Any, looks: list[Any]
) -> None:
    looked: list[Any] = []
    monkeypatch.setattr(shown, "find_field", lambda picture: looked.append(picture) or find_field(picture))
    enhancer.show(IMAGE)
    pooled = enhancer.enhance(looks[0]).statistics
    for look in looks:
        enhancer.enhance(look)
        enhancer.enhance(look, statistics=replace(pooled, field=None))
    assert len(looked) == 1


def test_a_field_of_another_size_is_refused() -> None:
    with pytest.raises(ImageError, match="expected a field of view of 160 x 120 pixels, got 8 x 4"):
        enhance(IMAGE, pixels=FieldOfView(8, 4))


@pytest.mark.parametrize("run", [enhance, enhance_vessels])
@pytest.mark.parametrize("dtype", TYPES)
def test_what_is_stored_where_alpha_is_0_reaches_no_pixel(run: Any, dtype: Any) -> None:
    """Neither black, a cut-out's, nor noise; and it stays."""
    seen = seen_in(np.ones((120, 160), bool))
    hidden = np.zeros((120, 160), bool)
    hidden[:, 100:] = hidden[30:50, 20:60] = True
    results = []
    for stored in (seen, np.zeros_like(seen), np.random.default_rng(0).integers(0, 256, seen.shape)):
        colors = np.where(hidden[..., None], stored, seen)
        given = as_type(np.dstack((colors, np.where(hidden, 0, 255))) / 255, dtype)
        result = run(given)
        assert np.array_equal(result.image[hidden], given[hidden])
        results.append((result.image[~hidden], result.statistics))
    for image, statistics in results[1:]:
        assert np.array_equal(image, results[0][0])
        assert statistics == results[0][1]


def test_hidden_pixels_have_no_part_in_the_typical_density() -> None:
    density, nothing = np.zeros((60, 80), np.float32), np.zeros((60, 80), np.float32)
    density[:, 50:] = 1
    alpha = np.zeros((120, 160), np.uint8)
    alpha[:, 100:] = 255
    assert middle_density(density, nothing, 2, EVERYWHERE, ALL_KEPT) == 0
    assert middle_density(density, nothing, 2, EVERYWHERE, alpha) == 1


@pytest.mark.parametrize("run", [enhance, enhance_vessels])
def test_a_field_beside_the_picture_has_nothing_to_measure(run: Any) -> None:
    nowhere = FieldOfView(160, 120, circle=(-90.0, -90.0, 5.0))
    with pytest.raises(ImageError, match="at least one pixel to measure"):
        run(IMAGE, pixels=nowhere)
