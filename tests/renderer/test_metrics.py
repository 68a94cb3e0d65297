"""Image metrics against their definitions."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from renderer.metrics import (
    depth_abs_rel,
    depth_coverage,
    depth_rmse,
    psnr,
    psnr_masked,
    ssim,
    ssim_masked,
)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(7)


def literal_ssim(image, reference, mask):
    """The definition, one window at a time."""
    x, y = image * mask[:, :, None], reference * mask[:, :, None]
    axis = np.arange(-5, 6)
    line = np.exp(-(axis**2) / (2 * 1.5**2))
    window = np.outer(line, line) / line.sum() ** 2
    values = []
    for channel in range(x.shape[2]):
        a, b = (np.pad(picture[:, :, channel], 5) for picture in (x, y))
        for row in range(x.shape[0]):
            for column in range(x.shape[1]):
                p, q = (picture[row : row + 11, column : column + 11] for picture in (a, b))
                mp, mq = (window * p).sum(), (window * q).sum()
                vp, vq = (window * p * p).sum() - mp**2, (window * q * q).sum() - mq**2
                cov = (window * p * q).sum() - mp * mq
                top = (2 * mp * mq + 1e-4) * (2 * cov + 9e-4)
                values.append(top / ((mp**2 + mq**2 + 1e-4) * (vp + vq + 9e-4)))
    return np.mean(values)


def test_psnr_of_a_constant_error_is_known():
    reference = np.full((8, 9, 3), 0.5)
    everything = np.ones((8, 9), dtype=bool)
    assert psnr(reference + 0.1, reference, everything) == pytest.approx(20.0, abs=1e-9)
    assert psnr_masked(reference + 0.1, reference, everything) == pytest.approx(20.0, abs=1e-9)


def test_whole_numbers_are_on_no_known_scale():
    grey, everything = np.full((8, 9, 3), 0.5), np.ones((8, 9), dtype=bool)
    for measure in (psnr, psnr_masked, ssim):
        for pair in ((grey, np.uint8(255 * grey)), (np.uint8(255 * grey), grey)):
            with pytest.raises(ValueError, match=r"floats in \[0, 1\], got uint8"):
                measure(*pair, everything)  # type: ignore[call-arg]


@pytest.mark.parametrize("rows", [1, 3, 7])
def test_the_two_psnr_differ_by_the_share_of_the_mask(rows):
    reference = np.full((8, 9, 3), 0.5, dtype=np.float32)
    mask = np.zeros((8, 9), dtype=bool)
    mask[:rows] = True
    gap = psnr(reference + 0.25, reference, mask) - psnr_masked(reference + 0.25, reference, mask)
    assert gap == pytest.approx(-10 * math.log10(rows / 8), abs=1e-9)


def test_pixels_outside_the_mask_do_not_matter(rng):
    reference, image = rng.random((2, 12, 13, 3))
    mask = rng.random((12, 13)) > 0.4
    changed = np.where(mask[:, :, None], image, np.nan)
    for measure in (psnr, psnr_masked, ssim):
        assert measure(changed, reference, mask) == measure(image, reference, mask)


def test_equal_pictures_are_perfect(rng):
    image = rng.random((16, 17, 3)).astype(np.float32)
    mask = rng.random((16, 17)) > 0.3
    assert ssim(image, image, mask) == pytest.approx(1.0, abs=1e-12)
    assert psnr(image, image, mask) == psnr_masked(image, image, mask) == math.inf


def test_ssim_matches_the_literal_windows(rng):
    reference = rng.random((14, 13, 3))
    image = np.clip(reference + 0.2 * rng.standard_normal(reference.shape), 0, 1)
    mask = rng.random((14, 13)) > 0.2
    assert ssim(image, reference, mask) == pytest.approx(literal_ssim(image, reference, mask), abs=1e-12)


def test_ssim_takes_grey_and_falls_with_noise(rng):
    reference = rng.random((20, 21))
    mask = np.ones((20, 21), dtype=bool)
    values = [ssim(reference + s * rng.standard_normal((20, 21)), reference, mask) for s in (0.01, 0.1, 0.5)]
    assert values == sorted(values, reverse=True)
    assert ssim(reference[:, :, None], reference[:, :, None], mask) == pytest.approx(1.0)


def test_depth_rmse_counts_only_where_both_are_measured():
    reference = np.array([[50.0, 60.0, 0.0, 70.0]], dtype=np.float32)
    depth = np.array([[53.0, 56.0, 99.0, 0.0]], dtype=np.float32)
    mask = np.array([[True, True, True, True]])
    assert depth_rmse(depth, reference, mask) == pytest.approx(math.sqrt((9 + 16) / 2))
    assert depth_rmse(depth, reference, np.array([[True, False, True, True]])) == pytest.approx(3.0)


def test_infinite_depth_is_not_measured():
    depth = np.array([[11.0, 20.0, np.inf, 0.0]], dtype=np.float32)
    reference, mask = np.array([[10.0, np.inf, 10.0, 10.0]], dtype=np.float32), np.ones((1, 4), dtype=bool)
    assert depth_rmse(depth, reference, mask) == 1
    assert depth_abs_rel(depth, reference, mask) == pytest.approx(0.1)
    assert depth_coverage(depth, reference, mask) == pytest.approx(1 / 3)


def test_relative_depth_error_is_without_unit_and_of_the_same_pixels(rng):
    reference = np.array([[50.0, 80.0, 0.0, 70.0]], dtype=np.float32)
    depth = np.array([[53.0, 76.0, 99.0, 0.0]], dtype=np.float32)
    mask = np.array([[True, True, True, True]])
    assert depth_abs_rel(depth, reference, mask) == pytest.approx((3 / 50 + 4 / 80) / 2)
    assert depth_coverage(depth, reference, mask) == pytest.approx(2 / 3)
    depth, reference = 20 + 80 * rng.random((2, 9, 8))
    everything = np.ones((9, 8), dtype=bool)
    assert depth_coverage(depth, reference, everything) == 1
    metres = depth_abs_rel(depth / 1000, reference / 1000, everything)
    assert depth_abs_rel(depth, reference, everything) == pytest.approx(metres)
    assert depth_rmse(depth, reference, everything) == pytest.approx(
        1000 * depth_rmse(depth / 1000, reference / 1000, everything)
    )


def test_depth_is_never_rounded():
    reference = np.full((6, 7), 55.5)
    everything = np.ones((6, 7), dtype=bool)
    assert depth_rmse(reference + 0.001, reference, everything) == pytest.approx(0.001)
    assert depth_rmse(reference + 300.25, reference, everything) == pytest.approx(300.25)


def test_nothing_to_measure_is_nan():
    empty = np.zeros((4, 5), dtype=bool)
    for measure in (depth_rmse, depth_abs_rel, depth_coverage):
        assert math.isnan(measure(np.ones((4, 5)), np.ones((4, 5)), empty))
        assert math.isnan(measure(np.ones((4, 5)), np.zeros((4, 5)), ~empty))
    assert math.isnan(psnr_masked(np.ones((4, 5, 3)), np.zeros((4, 5, 3)), empty))


@pytest.mark.parametrize("measure", [psnr, psnr_masked, ssim, depth_rmse, depth_abs_rel, depth_coverage])
def test_shapes_that_do_not_agree_are_refused(measure):
    with pytest.raises(ValueError, match=r"\(4, 5\), \(4, 6\)"):
        measure(np.ones((4, 5)), np.ones((4, 6)), np.ones((4, 5), dtype=bool))
    with pytest.raises(ValueError, match="bool mask"):
        measure(np.ones((4, 5)), np.ones((4, 5)), np.ones((4, 5)))


@pytest.mark.parametrize("measure", [psnr, psnr_masked, ssim, ssim_masked])
def test_a_few_rows_at_a_time_are_the_whole_image(
    measure: Callable[..., float], monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(2)
    image, reference, mask = rng.random((90, 40, 3)), rng.random((90, 40, 3)), rng.random((90, 40)) < 0.7
    whole = measure(image, reference, mask)
    monkeypatch.setattr("renderer.metrics._PIXELS", 1)
    assert measure(image, reference, mask) == pytest.approx(whole, rel=1e-12)
