"""The terms of the loss that are not of each pixel alone, against literal sums and central differences."""

from __future__ import annotations

import numpy as np
import pytest

from renderer.rasterize.tiles import LEFT, PLANE_DEPTH, PLANE_RED
from renderer.train.similarity import C1, C2, add_dissimilarity
from renderer.train.variation import add_variation

HEIGHT, WIDTH = 18, 23


def blended(seed: int = 0) -> np.ndarray:
    """(5, H, W) planes with some places where little is drawn."""
    rng = np.random.default_rng(seed)
    planes = rng.uniform(0.1, 0.9, (5, HEIGHT, WIDTH)).astype(np.float32)
    planes[LEFT] = np.where(rng.uniform(size=(HEIGHT, WIDTH)) < 0.2, 0.8, 0.1)
    planes[PLANE_DEPTH] = (1 - planes[LEFT]) * rng.uniform(40, 60, (HEIGHT, WIDTH))
    return planes


def test_variation_is_the_sum_over_neighbours() -> None:
    planes = blended()
    extra = np.zeros((4, HEIGHT, WIDTH), np.float32)
    got = add_variation(planes, 0.3, 20.0, extra)
    color = planes[PLANE_RED : PLANE_RED + 3].astype(np.float64)
    total = np.abs(np.diff(color, axis=1)).sum() + np.abs(np.diff(color, axis=2)).sum()
    drawn = planes[LEFT] < 0.5
    inverse = (1 - planes[LEFT].astype(np.float64)) / planes[PLANE_DEPTH]
    near = sum(
        np.abs(np.diff(inverse, axis=axis))[first & second].sum()
        for axis, first, second in ((0, drawn[:-1], drawn[1:]), (1, drawn[:, :-1], drawn[:, 1:]))
    )
    expected = 0.3 * total / color.size + 20.0 * near / inverse.size
    assert got == pytest.approx(expected, rel=1e-5)


def test_slopes_of_the_variation() -> None:
    planes = blended()
    extra = np.zeros((4, HEIGHT, WIDTH), np.float32)
    add_variation(planes, 0.3, 20.0, extra)
    for y, x in ((0, 0), (5, 7), (HEIGHT - 1, WIDTH - 1), (9, 0)):
        changed = planes.copy()
        changed[PLANE_RED + 1, y, x] += 1e-4
        ahead = add_variation(changed, 0.3, 0.0, np.zeros_like(extra))
        slope = (ahead - add_variation(planes, 0.3, 0.0, np.zeros_like(extra))) / 1e-4
        assert extra[1, y, x] == pytest.approx(slope, abs=2e-5)
    y, x = np.argwhere(planes[LEFT] < 0.5)[11]
    changed, weight = planes.copy(), 1 - planes[LEFT, y, x]
    changed[PLANE_DEPTH, y, x] += 0.01 * weight  # 0.01 in expected depth
    ahead, here = (add_variation(some, 0.0, 20.0, np.zeros_like(extra)) for some in (changed, planes))
    assert extra[3, y, x] == pytest.approx((ahead - here) / 0.01, rel=0.02)
    assert not extra[3][planes[LEFT] > 0.5].any()


def pictures(seed: int = 1) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    image = rng.uniform(0, 1, (3, HEIGHT, WIDTH)).astype(np.float32)
    picture = np.clip(image + rng.normal(0, 0.1, image.shape), 0, 1).astype(np.float32)
    mask = np.ones((HEIGHT, WIDTH), np.float32)
    mask[:6, 10:] = 0
    return picture, image, mask


def literal_dissimilarity(picture: np.ndarray, image: np.ndarray, mask: np.ndarray) -> float:
    """Every window by hand, float64."""
    offsets = np.arange(-5, 6)
    line = np.exp(-(offsets**2) / (2 * 1.5**2))
    line /= line.sum()
    total, count = 0.0, 0
    for channel in range(3):
        for y, x in np.argwhere(mask > 0):
            weights, a, b = [], [], []
            for i, dy in enumerate(offsets):
                for j, dx in enumerate(offsets):
                    row, column = y + dy, x + dx
                    if 0 <= row < HEIGHT and 0 <= column < WIDTH and mask[row, column] > 0:
                        weights.append(line[i] * line[j])
                        a.append(float(picture[channel, row, column]))
                        b.append(float(image[channel, row, column]))
            w = np.array(weights) / np.sum(weights)
            first, second = np.array(a), np.array(b)
            mean_a, mean_b = w @ first, w @ second
            variance_a, variance_b = w @ (first - mean_a) ** 2, w @ (second - mean_b) ** 2
            covariance = w @ ((first - mean_a) * (second - mean_b))
            similarity = (2 * mean_a * mean_b + C1) * (2 * covariance + C2)
            total += similarity / ((mean_a**2 + mean_b**2 + C1) * (variance_a + variance_b + C2))
            count += 1
    return 1 - total / count


def test_dissimilarity_is_the_literal_one() -> None:
    picture, image, mask = pictures()
    got = add_dissimilarity(picture, image, mask, 0.7, np.zeros_like(picture))
    assert got == pytest.approx(0.7 * literal_dissimilarity(picture, image, mask), rel=1e-4)


def test_slope_of_the_dissimilarity() -> None:
    picture, image, mask = pictures()
    extra = np.zeros((4, HEIGHT, WIDTH), np.float32)
    add_dissimilarity(picture, image, mask, 0.7, extra)
    rng = np.random.default_rng(2)
    for _ in range(5):
        direction = rng.normal(size=picture.shape).astype(np.float32)
        ahead, behind = (
            add_dissimilarity(
                picture + np.float32(sign * 1e-3) * direction, image, mask, 0.7, np.zeros_like(extra)
            )
            for sign in (1, -1)
        )
        assert float((extra[:3] * direction).sum()) == pytest.approx((ahead - behind) / 2e-3, rel=0.02)
    assert not extra[:, mask == 0].any()


def test_dissimilarity_of_the_same_pictures_is_none_and_the_mask_hides_the_rest() -> None:
    picture, image, mask = pictures()
    assert add_dissimilarity(image, image, mask, 1.0, np.zeros_like(image)) == pytest.approx(0, abs=1e-5)
    other = np.where(mask > 0, picture, 0.123).astype(np.float32)
    first, second = np.zeros_like(image), np.zeros_like(image)
    assert add_dissimilarity(picture, image, mask, 1.0, first) == pytest.approx(
        add_dissimilarity(other, image, mask, 1.0, second), rel=1e-6
    )
    assert np.array_equal(first, second)
    assert add_dissimilarity(picture, image, np.zeros_like(mask), 1.0, np.zeros_like(image)) == 0
