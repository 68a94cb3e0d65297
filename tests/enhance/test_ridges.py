from __future__ import annotations

from itertools import permutations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from enhance import ImageError
from enhance.color_difference import LEAST, vessel_color_difference
from enhance.metrics import line_scale, vessel_cnr, vessel_contrast
from enhance.reference import ridge
from enhance.ridges import (
    GLARE_MARGIN,
    LEAST_AREA,
    LEAST_SIGMA,
    MARGIN,
    creases,
    field_of_view,
    vessel_mask,
    vesselness,
)
from tests.enhance.pictures import vessels
from tests.enhance.test_real_images import read


def line(angle: float, width: float, depth: float = 0.2, size: int = 61) -> NDArray[np.float64]:
    """Grey 0.6 with a Gaussian dark line through the centre, at `angle` radians."""
    y, x = np.mgrid[0:size, 0:size] - size // 2
    across = -np.sin(angle) * x + np.cos(angle) * y
    return 0.6 - depth * np.exp(-(across**2) / (2 * width**2))


@pytest.mark.parametrize("angle", [0.0, 0.4, np.pi / 4, np.pi / 2, 2.5])
@pytest.mark.parametrize(("width", "sigma"), [(1.5, 1.5), (3.0, 2.0), (2.0, 4.0)])
def test_strength_at_a_line_is_the_blurred_second_derivative(
    angle: float, width: float, sigma: float
) -> None:
    image = line(angle, width)
    got = vesselness(image, [sigma])[30, 30]
    spread = width**2 + sigma**2
    level = 0.6 - 0.2 * width / np.sqrt(spread) + 0.1 * (0.6 - (0.6 - image).mean())
    assert got == pytest.approx(2 * 0.2 * width * sigma**2 / spread**1.5 / 2 / level, rel=0.02)


@pytest.mark.parametrize("shape", [(1, 1), (1, 50), (5, 3), (61, 300)])
@pytest.mark.parametrize("sigma", [0.3, 1.5, 4.0, 20.0])
def test_strength_is_that_of_the_reference(shape: tuple[int, int], sigma: float) -> None:
    image = np.random.default_rng(0).random(shape, np.float32)
    wanted = ridge(image.astype(np.float64), sigma)
    np.testing.assert_allclose(vesselness(image, [sigma]), wanted, rtol=1e-6, atol=1e-12)


def test_order_of_scales_does_not_matter() -> None:
    image = vessels()
    results = [vesselness(image, sigmas) for sigmas in permutations((1.0, 2.0, 4.5))]
    assert all(np.array_equal(results[0], other) for other in results[1:])
    assert np.all(results[0] >= vesselness(image, [2.0]))


@pytest.mark.parametrize("level", [0.0, 0.3, 1.0])
def test_nothing_in_a_constant_image(level: float) -> None:
    assert vesselness(np.full((30, 40, 3), level)).max() < 1e-6
    assert not vessel_mask(np.full((60, 60, 3), level)).any()


def test_gain_falls_out() -> None:
    image = vessels() / 255
    np.testing.assert_allclose(vesselness(0.4 * image), vesselness(image), rtol=1e-4, atol=1e-6)


def test_dark_lines_count_and_bright_lines_spots_and_steps_hardly() -> None:
    dark = vesselness(line(0.7, 2.0))[25:36, 25:36].max()
    y, x = np.mgrid[0:61, 0:61] - 30
    spot = 0.6 - 0.2 * np.exp(-(x**2 + y**2) / 8)
    step = np.where(x > 0, 0.6, 0.4)
    bright = line(0.7, 2.0, depth=-0.2)
    assert vesselness(bright)[30, 30] == 0
    assert vesselness(spot)[30, 30] < 0.05 * dark
    assert vesselness(step)[20:40, 20:40].max() < 0.35 * dark


def test_only_green_counts() -> None:
    colors = np.full((61, 61, 3), 0.5)
    colors[..., 1] = line(0.3, 2.0)
    assert np.array_equal(vesselness(colors), vesselness(line(0.3, 2.0)))
    assert vesselness(colors[..., [1, 0, 2]]).max() < 1e-6


def test_field_of_view_is_all_but_the_dark_around() -> None:
    y, x = np.mgrid[0:120, 0:160]
    away = np.hypot(x - 80, y - 60)
    circle = away < 50
    image = np.where(circle[..., None], np.array([180, 90, 70], np.uint8), np.uint8(4))
    image[55:65, 75:85] = 0  # a dark lumen inside the picture is no surround
    assert not field_of_view(image)[~circle].any()
    assert field_of_view(image)[away < 47].all()
    assert field_of_view(vessels(60, 60) // 2 + 100).all()


def test_what_is_transparent_is_dark_to_the_field_of_view_whatever_is_stored_there() -> None:
    image = vessels(240, 320)
    alpha = np.full(image.shape[:2], 255, np.uint8)
    alpha[:, :60], alpha[:, 260:] = 0, 0
    black = np.where(alpha[..., None] > 0, image, 0).astype(np.uint8)
    expected = field_of_view(black)
    assert 0.5 < expected.mean() < 0.7
    assert np.array_equal(field_of_view(np.dstack((image, alpha))), expected)


def test_mask_finds_drawn_vessels_and_keeps_its_distance() -> None:
    rng = np.random.default_rng(5)
    y, x = np.mgrid[0:200, 0:200]
    distance = np.abs(x - 100 - 20 * np.sin(y / 25))
    green = 0.5 - 0.15 * np.exp(-((distance / 2) ** 2)) + rng.normal(0, 0.004, x.shape)
    image = np.stack([0.7 + 0 * green, green, green], axis=2)
    mask = vessel_mask(image, share=0.03)
    assert mask.sum() > 500
    assert np.mean(distance[mask] < 3) > 0.98
    tissue = y < 120
    assert not vessel_mask(image, tissue_mask=tissue)[120 - MARGIN :].any()
    assert not mask[:MARGIN].any()
    assert mask[MARGIN:30].any()
    assert vessel_mask(image, tissue_mask=tissue)[: 120 - MARGIN].any()
    image[90:110, 90:130] = 1.0
    near = vessel_mask(image, share=0.03)[90 - GLARE_MARGIN // 2 : 110 + GLARE_MARGIN // 2, 90:130]
    assert not near.any()


def test_mask_holds_at_most_its_share_and_no_specks() -> None:
    noise = np.clip(np.random.default_rng(6).normal(0.5, 0.05, (150, 150, 3)), 0, 1)
    assert vessel_mask(noise, share=0.02).mean() <= 0.02
    short, long = np.full((2, 100, 100), 0.5)
    short[50, 45:50] = 0.2
    long[50, 30:70] = 0.2
    assert vessel_mask(short, share=0.5 * LEAST_AREA / short.size).sum() == 0
    assert vessel_mask(long, share=0.02).sum() >= LEAST_AREA


def test_what_is_stored_where_alpha_is_0_is_no_vessel() -> None:
    image = np.full((120, 160, 3), (180, 110, 100), np.uint8)
    image[:, 40:44] = (150, 80, 70)
    stripes = image.copy()
    stripes[:, 90::9] = 0
    alpha = np.full((120, 160), 255, np.uint8)
    alpha[:, 80:] = 0
    bare, striped = (np.dstack((colors, alpha)) for colors in (image, stripes))
    assert np.array_equal(vesselness(striped), vesselness(bare))
    for tissue in (None, np.ones((120, 160), bool)):
        mask = vessel_mask(striped, tissue_mask=tissue)
        assert np.array_equal(mask, vessel_mask(bare, tissue_mask=tissue))
        assert np.array_equal(mask[:, :80], vessel_mask(image[:, :80]))
        assert mask.any()
        assert not mask[:, 80 - MARGIN :].any()


def test_bad_input_is_refused() -> None:
    with pytest.raises(ImageError, match="at least one sigma"):
        vesselness(vessels(), [])
    with pytest.raises(ImageError, match="tissue_mask of shape"):
        vessel_mask(vessels(20, 30), tissue_mask=np.ones((30, 20), bool))
    with pytest.raises(ImageError, match="bool or integers"):
        vessel_mask(vessels(20, 30), tissue_mask=np.ones((20, 30)))


@pytest.mark.data
def test_mask_of_a_retina_lies_on_annotated_vessels() -> None:
    image, annotated = read("retina/Image_02L.jpg"), read("retina/Image_02L_1stHO.png")[..., 0] > 0
    mask = vessel_mask(image)
    assert np.mean(annotated[mask]) > 0.8
    assert mask.sum() > 0.25 * annotated.sum()


@pytest.mark.parametrize("number", [0.0, 1e-3, -2.0, np.nan, np.inf])
def test_numbers_that_mean_nothing_are_refused(number: float) -> None:
    with pytest.raises(ImageError, match=r"expected sigmas of at least 0\.05 pixels"):
        vesselness(vessels(), [2.0, number])
    if number != 1e-3:
        with pytest.raises(ImageError, match="expected a share above 0, up to 1"):
            vessel_mask(vessels(), share=number)


def test_scales_are_any_sequence() -> None:
    sigmas = (LEAST_SIGMA, 1.5, 2.5)
    found = vesselness(vessels(), np.array(sigmas))  # type: ignore[arg-type]
    assert np.isfinite(found).all()
    assert np.array_equal(found, vesselness(vessels(), sigmas))


@pytest.mark.parametrize(("times", "least", "more"), [(2, 0.6, 0.05), (4, 0.4, 0.15)])
def test_a_small_image_has_the_vessels_of_a_large_one(times: int, least: float, more: float) -> None:
    """By lengths that are scaled; in pixels, lines of another width are found, or none."""
    large = cv2.GaussianBlur(vessels(480, 640, 3), (0, 0), 1.0)
    size = 640 // times, 480 // times
    small = cv2.resize(large, size, interpolation=cv2.INTER_AREA)
    found = vessel_mask(large, scale=line_scale(large))
    shrunk = cv2.resize(found.astype(np.float32), size, interpolation=cv2.INTER_AREA) >= 0.5

    def shared(scale: float) -> float:
        mask = vessel_mask(small, scale=scale)
        return float(2 * (mask & shrunk).sum() / (mask.sum() + shrunk.sum()))

    assert np.array_equal(found, vessel_mask(large))
    assert shared(line_scale(small)) > max(least, shared(1.0) + more)


@pytest.mark.parametrize("shape", [(1, 1), (1, 60), (3, 2), (16, 16), (48, 48), (64, 64)])
@pytest.mark.parametrize("level", [None, 0, 128, 255])
def test_tiny_images_are_measured_without_complaint(shape: tuple[int, int], level: int | None) -> None:
    rng = np.random.default_rng(0)
    image = (
        rng.integers(0, 256, (*shape, 3), np.uint8)
        if level is None
        else np.full((*shape, 3), level, np.uint8)
    )
    scale = line_scale(image)
    mask = vessel_mask(image, scale=scale)
    assert mask.mean() <= 0.05
    for measure in (vessel_contrast, vessel_cnr):
        assert np.isfinite(measure(image, mask, scale=scale)) == mask.any()
    # Too few pixels in every block say nothing.
    assert np.isfinite(vessel_color_difference(image, mask, scale=scale)) or mask.sum() < 4 * LEAST
    assert not creases(image, scale=scale).all()
