from __future__ import annotations

import cv2
import numpy as np
import pytest

from enhance import Enhancer, LiveStatistics
from enhance.field import FieldOfView, overlap
from enhance.field_tracker import EVERY, FieldTracker
from enhance.image import AnyImage, read_picture
from tests.enhance.endoscopes import APART, OUTLINES, agreement, outline, seen_in

ROUND, SHIFTED = outline("circle"), outline("beside the middle")


def followed(tracker: FieldTracker, images: list[AnyImage]) -> list[FieldOfView]:
    return [tracker.follow(read_picture(image)) for image in images]


@pytest.mark.parametrize("name", [*OUTLINES, *APART])
def test_noise_does_not_move_the_field(name: str) -> None:
    field = outline(name)
    fields = followed(FieldTracker(), [seen_in(field, noise=4, seed=seed) for seed in range(3 * EVERY)])
    assert len(set(fields)) == 1
    assert agreement(fields[0].mask(), field) > 0.92


def test_neither_flash_nor_dark_moment_moves_it() -> None:
    flash, dark = np.full((240, 320, 3), 255, np.uint8), np.zeros((240, 320, 3), np.uint8)
    steady = [seen_in(ROUND, seed=seed) for seed in range(EVERY)]
    fields = followed(FieldTracker(), [*steady, flash, *steady, dark, dark, *steady])
    assert len(set(fields)) == 1


def test_a_lumen_that_grows_dark_beside_the_rim_does_not_move_it() -> None:
    y, x = np.mgrid[:240, :320] + 0.5
    lumen = cv2.GaussianBlur((np.hypot(x - 230, y - 120) < 55).astype(np.float64), (0, 0), 3)[..., None]
    images = list[AnyImage]()
    for step in range(5 * EVERY):
        dark = np.clip(step / (3 * EVERY), 0, 1) * lumen
        images.append((seen_in(ROUND, seed=step) * (1 - dark) + 3 * dark).astype(np.uint8))
    assert len(set(followed(FieldTracker(), images))) == 1


def test_a_new_field_takes_its_place_within_two_looks() -> None:
    tracker = FieldTracker()
    followed(tracker, [seen_in(ROUND)])
    fields = followed(tracker, [seen_in(SHIFTED)] * (2 * EVERY))
    assert overlap(fields[0], fields[-1]) < 0.8
    assert len(set(fields)) == 2
    assert agreement(fields[-1].mask(), SHIFTED) > 0.97


@pytest.mark.parametrize(("pixels", "least"), [(1, 0.8), (2, 0.65)])
def test_a_field_that_moves_all_the_while_is_followed(pixels: int, least: float) -> None:
    """Two looks in a row never agree on where it is."""
    tracker, places = FieldTracker(), range(-48, 49, pixels)
    moved = [np.roll(ROUND, place, axis=1) for place in places]
    fields = followed(tracker, [seen_in(field, seed=step) for step, field in enumerate(moved)])
    kept = [agreement(field.mask(), true) for field, true in zip(fields, moved, strict=True)]
    assert min(kept) > least
    assert overlap(fields[0], fields[-1]) < 0.6


def test_a_stream_that_begins_in_the_dark_finds_it_later() -> None:
    tracker = FieldTracker()
    assert followed(tracker, [np.zeros((240, 320, 3), np.uint8)])[0].is_whole
    assert agreement(followed(tracker, [seen_in(ROUND)])[0].mask(), ROUND) > 0.97


def test_another_size_is_looked_at_anew() -> None:
    tracker = FieldTracker()
    followed(tracker, [seen_in(ROUND)])
    small = outline("circle", 120, 160)
    assert agreement(followed(tracker, [seen_in(small)])[0].mask(), small) > 0.93


def test_a_live_stream_keeps_its_mask_while_noise_changes() -> None:
    enhancer, fields = Enhancer(LiveStatistics()), set()
    for seed in range(2 * EVERY + 1):
        image = seen_in(ROUND, noise=4, seed=seed)
        enhancer.show(image)
        result = enhancer.enhance().image
        assert enhancer.field is not None
        fields.add(enhancer.field)
        outside = ~enhancer.field.mask()
        assert np.array_equal(result[outside], image[outside])
    assert len(fields) == 1
