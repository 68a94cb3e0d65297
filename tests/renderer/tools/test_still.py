"""What stands still is masked wherever it looks the same; nothing that moves leaves a trail."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from renderer.clip import ByteImage
from renderer.tools.still import NOISE, StillArea, still_areas

WIDTH, HEIGHT, FRAMES = 320, 240, 16
PANEL = np.s_[215:235, 0:90]


def tissue(frame: int) -> ByteImage:
    """Red, at rest, with the noise of a camera."""
    noise = np.random.default_rng(frame).normal(0, 2, (HEIGHT, WIDTH, 3))
    return np.clip(np.array((150, 70, 60)) + noise, 0, 255).astype(np.uint8)


def with_panel(image: ByteImage) -> ByteImage:
    """Dark, with bright strokes as of text."""
    image[PANEL] = (40, 40, 38)
    image[220:230:4, 10:80] = 220
    return image


def marked(*places: tuple[slice, slice]) -> NDArray[np.uint8]:
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    for place in places:
        mask[place] = 1
    return mask


NOTHING = marked()


@pytest.fixture(scope="module")
def area() -> StillArea:
    """The panel, missed in every fourth frame, a bar that moves above it and touches it at first, in all."""
    images = [with_panel(tissue(frame)) for frame in range(FRAMES)]
    found = list[NDArray[np.uint8]]()
    for frame, image in enumerate(images):
        bar = np.s_[195 - 8 * frame : 215 - 8 * frame, 0:150]
        image[bar] = 90
        found.append(marked(bar, PANEL) if frame % 4 else marked(bar))
    (only,) = still_areas(images, found)
    return only


def test_it_is_masked_in_all_frames_that_show_it_and_alone(area: StillArea) -> None:
    for frame in (0, 4, 99):
        added = area.added(NOTHING, with_panel(tissue(frame)))
        assert np.count_nonzero(added[PANEL]) > 0.95 * 20 * 90
        assert np.count_nonzero(added) == np.count_nonzero(added[PANEL])
    bar = marked(np.s_[50:60, 50:60])
    assert np.array_equal(
        area.added(bar, with_panel(tissue(0))), bar | area.added(NOTHING, with_panel(tissue(0)))
    )
    assert not NOTHING.any()


@pytest.mark.parametrize("is_darker", [False, True])
def test_where_it_has_gone_or_looks_otherwise_tissue_is_seen(area: StillArea, is_darker: bool) -> None:
    image = with_panel(tissue(0)) // 2 if is_darker else tissue(0)
    assert area.added(NOTHING, image) is NOTHING


def test_what_hides_half_of_it_is_not_masked_with_it(area: StillArea) -> None:
    image = with_panel(tissue(0))
    image[:, :45] = (150, 70, 60)
    assert area.added(NOTHING, image) is NOTHING


def test_tissue_at_rest_that_is_found_in_few_frames_is_none() -> None:
    images = [tissue(frame) for frame in range(FRAMES)]
    assert (
        still_areas(images, [marked(PANEL) if frame % 3 == 0 else NOTHING for frame in range(FRAMES)]) == ()
    )


def test_what_is_found_throughout_and_changes_is_none() -> None:
    images = [with_panel(tissue(frame)) for frame in range(FRAMES)]
    for frame, image in enumerate(images):
        image[PANEL] = 40 + (frame % 2) * 3 * NOISE
    assert still_areas(images, [marked(PANEL)] * FRAMES) == ()


def test_of_two_frames_nobody_knows() -> None:
    assert still_areas([with_panel(tissue(0))] * 2, [marked(PANEL)] * 2) == ()
    assert len(still_areas([with_panel(tissue(0))] * 3, [marked(PANEL)] * 3)) == 1


def test_specks_are_left_to_each_frame() -> None:
    assert still_areas([tissue(0)] * 4, [marked(np.s_[10:20, 10:20])] * 4) == ()


def test_records_that_fit_no_image_mask_nothing(area: StillArea) -> None:
    image = with_panel(tissue(0))
    assert area.added(NOTHING, image) is not NOTHING
    assert replace(area, look=area.look[:6]).added(NOTHING, image) is NOTHING
    small = np.ascontiguousarray(image[:100, :100])
    unmasked = np.zeros((100, 100), np.uint8)
    assert area.added(unmasked, small) is unmasked
