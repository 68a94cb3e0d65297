"""Fields whose rim is hardly brighter than the surround, and what recorders leave beside it."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from enhance import field_rim
from enhance.field_rim import RAYS
from tests.enhance import field_oracle
from tests.enhance.endoscopes import agreement, assert_found, found, outline, seen_in


@pytest.mark.parametrize("size", [(240, 320), (720, 1280)])
@pytest.mark.parametrize("radius", [0.3, 0.45])
@pytest.mark.parametrize("black", [0, 12])
def test_a_lens_that_darkens_towards_its_rim_has_one(
    size: tuple[int, int], radius: float, black: float
) -> None:
    """Tissue beside the rim is some 8 grey levels brighter than the surround, as of bronchoscopes."""
    height, width = size
    y, x = np.mgrid[:height, :width] + 0.5
    away = np.hypot(x - width / 2, y - height / 2) / height
    shade = 0.5 * np.maximum(1 - 0.88 * (away / radius) ** 1.5, 0.12)
    image = black + seen_in(away < radius, black=0) * shade[..., None]
    assert_found(found(image.astype(np.uint8)).mask(), away < radius)


@pytest.mark.parametrize("name", ["cropped circle", "beside the middle", "octagon", "D"])
@pytest.mark.parametrize("size", [(240, 320), (720, 1280)])
@pytest.mark.parametrize("black", [0, 12])
def test_tissue_that_is_nearly_dark_at_the_rim_is_field(
    name: str, size: tuple[int, int], black: float
) -> None:
    field = outline(name, *size)
    depth = cv2.distanceTransform(field.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    shade = np.maximum(1 - 0.94 * (1 - depth / depth.max()) ** 3, 0.06)
    image = black + seen_in(field, black=0) * shade[..., None]
    assert_found(found(image.astype(np.uint8)).mask(), field, 8 * size[0] // 240)


@pytest.mark.parametrize("size", [(240, 320), (576, 720)])
@pytest.mark.parametrize("turn", [0, 2])
def test_lines_of_a_recorder_along_the_border_are_none_of_the_field(size: tuple[int, int], turn: int) -> None:
    field = outline("cropped circle", *size)
    image = seen_in(field)
    lines = 10 * size[0] // 576
    image[-lines:] = np.random.default_rng(0).integers(90, 250, (lines, size[1], 3))
    mask = found(np.rot90(image, turn)).mask()
    beside = np.rot90(np.arange(size[0])[:, None] < size[0] - 2 * lines, turn)
    assert_found(mask & beside, np.rot90(field, turn) & beside)
    assert not (mask & ~np.rot90(field, turn)).any()


@pytest.mark.parametrize("seed", range(8))
def test_how_soon_it_is_dark_beyond_a_rim_is_what_numpy_finds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    samples = int(rng.integers(12, 60))
    ends = rng.uniform(-3, samples, (RAYS, 1))
    away = (np.arange(samples) - ends) / rng.uniform(0.2, 9)
    values = (40 / (1 + np.exp(away)) + rng.uniform(0, 4, away.shape)).astype(np.float32)
    values[rng.random(RAYS) < 0.3, int(0.7 * samples) :] = -1
    threshold = float(rng.uniform(6, 30))
    assert field_rim._fall(values, threshold) == field_oracle.fall_of(values, threshold)


@pytest.mark.parametrize("name", ["circle", "octagon"])
def test_the_soft_rim_of_an_enlarged_image_is_none_of_the_field(name: str) -> None:
    image = cv2.resize(seen_in(outline(name, 90, 120)), (960, 720), interpolation=cv2.INTER_CUBIC)
    mask, field = found(image).mask(), outline(name, 720, 960)
    assert agreement(mask, field) > 0.95
    assert (mask & ~field).mean() < 0.005


@pytest.mark.parametrize("level", [25, 50])
@pytest.mark.parametrize("gap", [0, 4])
@pytest.mark.parametrize("size", [1, 2])
def test_the_inside_of_a_speculum_is_none_of_the_field(level: int, gap: int, size: int) -> None:
    y, x = np.mgrid[: 480 * size, : 640 * size] + 0.5
    away = np.hypot(x / size - 330, y / size - 235)
    light = np.where(away < 150, 170 - away / 4, np.where((away > 150 + gap) & (away < 200), level, 3))
    grain = np.random.default_rng(2).normal(0, 1, (*away.shape, 3))
    image = cv2.GaussianBlur(light, (0, 0), 0.8)[..., None] * np.array([1, 0.8, 0.75]) + grain
    field = found(np.rint(np.clip(image, 0, 255)).astype(np.uint8))
    assert field.circle is not None
    assert_found(field.mask(), away < 150, 8 * size)


@pytest.mark.parametrize("width", [0.02, 0.05, 0.1])
def test_a_lens_that_darkens_towards_its_rim_has_all_of_its_field(width: float) -> None:
    y, x = np.mgrid[:480, :640] + 0.5
    away = np.hypot(x - 320, y - 240) / 200
    light = np.where(away < 1, 40 + 130 / (1 + np.exp((away - 0.75) / width)), 3)
    grain = np.random.default_rng(2).normal(0, 1, away.shape)
    image = np.rint(np.clip(cv2.GaussianBlur(light, (0, 0), 0.8) + grain, 0, 255)).astype(np.uint8)
    assert_found(found(image).mask(), away < 1)
