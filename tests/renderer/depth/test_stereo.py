"""Disparity against the phantom's truth, pictures shifted by known amounts, and a real pair."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from renderer.depth.stereo import disparity, disparity_limits, feature_shifts
from renderer.readers.image_files.pictures import read_rgb, read_stored
from tests.renderer.eyes import BASELINE, Eyes, look

SCARED = Path(__file__).resolve().parents[3] / "../shared/data/scared/d1k1_rectified_pair"


@pytest.fixture(scope="module", params=[41, 42])
def eyes(request) -> Eyes:
    return look(width=320, height=256, seed=request.param)


@pytest.fixture(scope="module")
def found(eyes) -> np.ndarray:
    return disparity(eyes.left.image, eyes.right.image)


def grey(image: np.ndarray) -> np.ndarray:
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY))


def texture(height: int = 128, width: int = 256) -> np.ndarray:
    """Smooth random RGB; band-limited, so that it can be shifted by fractions of a pixel."""
    rng = np.random.default_rng(5)
    noise = cv2.GaussianBlur(rng.uniform(0, 1, (height, width, 3)), (0, 0), 1.5)
    return np.asarray(cv2.normalize(noise, None, 40, 220, cv2.NORM_MINMAX))


def shifted(image: np.ndarray, by: float) -> np.ndarray:
    """What the right eye sees of a picture whose disparity is `by` everywhere; shifted by Fourier."""
    phase = np.exp(2j * np.pi * np.fft.fftfreq(image.shape[1]) * by)[None, :, None]
    return np.asarray(np.fft.ifft(np.fft.fft(image, axis=1) * phase, axis=1).real)


def as_bytes(image: np.ndarray) -> np.ndarray:
    return np.clip(np.rint(image), 0, 255).astype(np.uint8)


def test_the_phantom_in_depth(eyes, found):
    """Within a fraction of a pixel nearly everywhere that both eyes see."""
    matched = eyes.seen & (found > 0)
    off = np.abs(found - eyes.disparity)[matched]
    depth = eyes.left.camera.fx * BASELINE / found[matched]
    assert eyes.left.depth is not None
    millimetres = np.abs(depth - eyes.left.depth[matched])
    share = matched.sum() / eyes.seen.sum()
    assert share > 0.85
    assert np.median(off) < 0.12
    assert np.mean(off > 1) < 0.03
    assert np.median(millimetres) < 0.4


def test_what_one_eye_alone_sees_has_no_depth(eyes, found):
    assert eyes.hidden.sum() > 1000
    wrong = (found > 0)[eyes.hidden].mean()
    assert wrong < 0.1
    assert (np.arange(320) - found)[found > 0].min() > -1


def test_a_shift_is_found_to_a_fraction_of_a_pixel():
    """The matcher alone is drawn to whole pixels by 0.1 to 0.2 here; the refinement takes that out."""
    picture = texture()
    for by in (7.0, 10.25, 10.5, 23.7):
        found = disparity(as_bytes(picture), as_bytes(shifted(picture, by)))
        inner = found[8:-8, 40:-8]
        assert (inner > 0).mean() > 0.95
        assert np.median(np.abs(inner[inner > 0] - by)) < 0.06
        assert np.mean(inner[inner > 0]) == pytest.approx(by, abs=0.03)


def test_shifts_beyond_what_the_matcher_counts_are_found_in_smaller_images():
    """As of eyes of 8K close to the tissue; OpenCV's numbers of 16 bits end at 2047 px."""
    rng = np.random.default_rng(5)
    image = sum(
        cv2.normalize(
            cv2.GaussianBlur(rng.uniform(0, 1, (192, 4608, 3)), (0, 0), scale), None, 20, 110, cv2.NORM_MINMAX
        )
        for scale in (2, 24)
    )
    found = disparity(as_bytes(image), as_bytes(shifted(image, 2150.4)))
    inner = found[30:-30, 2250:-30]
    assert np.mean(inner > 0) > 0.95
    assert abs(np.median(inner[inner > 0]) - 2150.4) < 0.1


def test_the_range_follows_the_scene():
    """Disparities up to 40 % of the width are found without being told, in pictures of any size."""
    picture = texture(160, 640)
    for by in (3, 60, 250):
        limits = disparity_limits(grey(as_bytes(picture)), grey(as_bytes(shifted(picture, by))))
        assert limits is not None
        assert limits[0] <= by <= limits[1]
        assert (limits[1] - limits[0]) % 16 == 0
        assert limits[1] - limits[0] <= 32
    found = disparity(as_bytes(picture), as_bytes(shifted(picture, 250.0)))
    assert np.median(found[:, 300:]) == pytest.approx(250, abs=0.1)


def test_light_that_differs_between_the_eyes_does_not_move_the_surface():
    picture = texture()
    right = shifted(picture, 12.4)
    dimmed = right * np.linspace(1.0, 0.6, right.shape[1])[None, :, None]
    found = disparity(as_bytes(picture), as_bytes(dimmed))[8:-8, 40:-8]
    assert (found > 0).mean() > 0.9
    assert np.median(np.abs(found[found > 0] - 12.4)) < 0.05


def test_pictures_without_a_match_have_no_disparity():
    """Chance alone matches a tenth of unrelated noise; equal pictures have no parallax."""
    one, other = np.random.default_rng(0).integers(0, 255, (2, 64, 96, 3)).astype(np.uint8)
    assert not disparity(one, other).any()
    assert not disparity(one, one).any()


@pytest.mark.parametrize("shape", [(1, 1), (1, 64), (40, 3), (24, 64)])
def test_flat_and_tiny_pictures_have_no_disparity(shape):
    flat = np.full((*shape, 3), 90, np.uint8)
    assert not disparity(flat, flat).any()


def test_two_sizes_are_refused():
    with pytest.raises(ValueError, match="one size"):
        disparity(np.zeros((4, 8, 3), np.uint8), np.zeros((4, 9, 3), np.uint8))


def test_the_number_of_threads_changes_nothing(eyes, found):
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        np.testing.assert_array_equal(disparity(eyes.left.image, eyes.right.image), found)
    finally:
        cv2.setNumThreads(threads)


@pytest.mark.parametrize("rows", [0, 2, -5])
def test_features_tell_how_far_rows_are_apart(eyes, rows):
    shifts = feature_shifts(eyes.left.image, np.roll(eyes.right.image, -rows, axis=0))
    assert len(shifts) > 50
    across, down = np.median(shifts, axis=0)
    assert down == pytest.approx(rows, abs=0.2)
    assert across == pytest.approx(np.median(eyes.disparity[eyes.seen]), abs=2)


def test_pictures_without_features_have_no_shifts():
    flat = np.full((40, 60, 3), 90, np.uint8)
    assert feature_shifts(flat, flat).shape == (0, 2)


@pytest.mark.data
@pytest.mark.skipif(not SCARED.is_dir(), reason="the SCARED pair is not there")
def test_a_real_pair():
    """The right picture, warped by the disparity, is the left one."""
    left, right = read_rgb(SCARED / "left.png"), read_rgb(SCARED / "right.png")
    found = disparity(left, right)
    known = found > 0
    rows, columns = np.indices(found.shape, dtype=np.float32)
    warped = cv2.remap(right, columns - found, rows, cv2.INTER_LINEAR)
    error = np.abs(warped.astype(float) - left).mean(axis=2)[known].mean()
    unwarped = np.abs(right.astype(float) - left).mean(axis=2)[known].mean()
    in_view = columns - np.median(found[known]) >= 0
    measured = read_stored(SCARED / "occ_left.png") == 255
    share, with_truth = known[in_view].mean(), known[in_view & measured].mean()
    without = known[in_view & ~measured].mean()
    assert error < unwarped / 4
    assert share > 0.8
    assert with_truth > without
    shifts = feature_shifts(left, right)
    assert np.median(np.abs(shifts[:, 1])) < 1
