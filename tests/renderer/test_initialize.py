"""Where the first Gaussians lie when some tissue is seldom seen, or has no depth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from renderer.camera import Camera
from renderer.clip import ClipError, Frame
from renderer.train.config import TrainConfig
from renderer.train.frames import train_frame
from renderer.train.initialize import DETAIL, EVENNESS, relative_detail, sampled, scene_size

WIDTH, HEIGHT, COUNT = 64, 48, 10
CAMERA = Camera(60.0, 60.0, WIDTH / 2, HEIGHT / 2, WIDTH, HEIGHT)
CONFIG = TrainConfig(n_gaussians=600)
RIGHT = np.s_[:, WIDTH // 2 :]


def frames(shown: int) -> list[Frame]:
    """Frames of which the first `shown` show the right half; their colour is their number."""
    made = []
    for index in range(COUNT):
        tissue, image = np.ones((HEIGHT, WIDTH), bool), np.full((HEIGHT, WIDTH, 3), index, np.uint8)
        tissue[RIGHT] = index < shown
        depth = np.full((HEIGHT, WIDTH), 50, np.float32)
        made.append(Frame(index, index / COUNT, image, CAMERA, tissue, tissue, depth))
    return made


def test_seldom_seen_tissue_gets_half_of_an_even_share_and_half_of_its_own() -> None:
    raw = sampled(frames(shown=1), CONFIG)
    right = np.count_nonzero(raw.means[:, 0] > 0) / len(raw)
    np.testing.assert_allclose(right, EVENNESS / 2 + (1 - EVENNESS) / 11, atol=0.01)


def test_sizes_follow_from_how_dense_the_samples_lie() -> None:
    raw = sampled(frames(shown=1), CONFIG)
    right = raw.means[:, 0] > 0
    pixel = 50 / CAMERA.fx
    for half in (right, ~right):
        spacing = np.sqrt(WIDTH * HEIGHT / 2 / np.count_nonzero(half)) * pixel
        np.testing.assert_allclose(np.exp(raw.log_scales[half]), CONFIG.initial_spacing * spacing, rtol=0.03)


def test_tissue_that_is_always_seen_is_sampled_alike_in_every_frame() -> None:
    raw = sampled(frames(shown=COUNT), CONFIG)
    numbers = np.rint(raw.colors[:, 0] * 255).astype(int)
    np.testing.assert_array_equal(np.bincount(numbers), CONFIG.n_gaussians // COUNT)


def test_tissue_without_depth_gets_its_gaussians_too() -> None:
    given = frames(shown=COUNT)
    for frame in given:
        assert frame.depth is not None
        frame.depth[RIGHT] = 0
    raw = sampled(given, CONFIG)
    right = np.count_nonzero(raw.means[:, 0] > 0) / len(raw)
    np.testing.assert_allclose(right, 0.5, atol=0.06)
    np.testing.assert_allclose(raw.means[:, 2], 50, rtol=1e-5)
    # What was filled in places them, and nothing is compared with it.
    assert not any(train_frame(frame).depth[RIGHT].any() for frame in given)
    assert {train_frame(frame).n_depths for frame in given} == {WIDTH * HEIGHT // 2}


def test_detailed_tissue_gets_more_and_smaller_gaussians() -> None:
    given = frames(shown=COUNT)
    for frame in given:
        frame.image[:] = 100
        frame.image[:, WIDTH // 2 :: 2] = 140
        frame.image[:, WIDTH // 2 + 1 :: 4] = 60
    raw = sampled(given, CONFIG, DETAIL)
    right = raw.means[:, 0] > 0
    # All of DETAIL goes there, but for what the blur takes over the border.
    assert 0.7 < np.mean(right) < (1 - DETAIL) / 2 + DETAIL
    away = np.abs(raw.means[:, 0]) > 50 * WIDTH / 4 / CAMERA.fx  # Beyond the blur.
    halves = away & ~right, away & right
    left_size, right_size = (np.exp(np.median(raw.log_scales[half])) for half in halves)
    left_count, right_count = (np.count_nonzero(half) for half in halves)
    np.testing.assert_allclose(left_size / right_size, np.sqrt(right_count / left_count), rtol=0.1)


def test_the_border_of_a_mask_is_no_detail() -> None:
    (frame,) = frames(shown=1)[:1]
    frame.image[:] = 90
    frame.tissue_mask[10:20, 10:30] = False
    frame.image[10:20, 10:30] = 255
    np.testing.assert_allclose(relative_detail(frame, DETAIL)[frame.tissue_mask], 1, atol=1e-5)


def test_masks_that_leave_out_all_depth_are_named() -> None:
    given = frames(shown=COUNT)
    with pytest.raises(ClipError, match="and its masks leave out all of it"):
        scene_size(replace(frame, tissue_mask=np.zeros((HEIGHT, WIDTH), bool)) for frame in given)
    nothing = np.zeros((HEIGHT, WIDTH), np.float32)
    with pytest.raises(ClipError, match="and its masks leave out all of it"):
        scene_size(replace(frame, tissue_mask=nothing > 0, depth=nothing) for frame in given)
    with pytest.raises(ClipError, match="and this clip has none"):
        scene_size(replace(frame, depth=nothing) for frame in given)
    with pytest.raises(ClipError, match="and this clip has none"):
        scene_size(replace(frame, depth=None) for frame in given)
