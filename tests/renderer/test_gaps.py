"""Gaps that open in tissue while a tool hides it are closed, and nothing else changes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.clip import Frame
from renderer.gaussians import DynamicGaussians
from renderer.rasterize.cpu import render
from renderer.raw_gaussians import RawGaussians
from renderer.splats import Float32Array
from renderer.train import gaps
from renderer.train.frames import TrainFrame, train_frame
from renderer.train.gaps import APART, COVERED, _clearest, closed_gaps
from tests.renderer.splines import without_nodes

CONTROLS, WIDTH, HEIGHT = 12, 64, 48
FOCAL, DEPTH, NEAR = 80.0, 10.0, 0.1
CAMERA = Camera(FOCAL, FOCAL, WIDTH / 2, HEIGHT / 2, WIDTH, HEIGHT)
TIMES = [index / 24 for index in range(24)]
OPENED, LATER = 0.4, 0.9
"""Times at which a tool hides the middle, and at which all is visible."""
MIDDLE, WITHIN = (slice(8, 40), slice(16, 48)), (slice(13, 35), slice(21, 43))
"""Hidden, and so far from what is visible that copies lie there in full."""


def is_hidden(time: float) -> bool:
    return 0.2 < time < 0.6


def frames(hide: bool = True) -> list[TrainFrame]:
    shown = []
    for index, time in enumerate(TIMES):
        mask = np.ones((HEIGHT, WIDTH), bool)
        mask[MIDDLE] = not (hide and is_hidden(time))
        image = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
        shown.append(train_frame(Frame(index, time, image, CAMERA, mask, mask)))
    return shown


def sheet(apart: float = 5.0) -> DynamicGaussians:
    """Gaussians 3 pixels from each other, of which the right half is so many pixels away while the middle is
    hidden."""
    columns, rows = np.meshgrid(np.arange(-60.0, 61, 3), np.arange(-60.0, 61, 3))
    pixels = np.stack([columns.ravel(), rows.ravel()], axis=1)
    means = np.column_stack([pixels * DEPTH / FOCAL, np.full(len(pixels), DEPTH)]).astype(np.float32)
    raw = RawGaussians(
        means=means,
        quats=np.tile(np.array([1, 0, 0, 0], np.float32), (len(means), 1)),
        log_scales=np.full((len(means), 3), np.log(2 * DEPTH / FOCAL), np.float32),
        opacity_logits=np.full(len(means), 3, np.float32),
        colors=np.full((len(means), 3), 0.5, np.float32),
        harmonics=np.zeros((len(means), 0, 3), np.float32),
    )
    positions = np.zeros((len(means), CONTROLS, 3), np.float32)
    away = np.exp(-(((np.arange(CONTROLS) - 5) / 1.5) ** 2)) * apart * DEPTH / FOCAL
    positions[pixels[:, 0] > 0, :, 0] = away
    motion = without_nodes(positions)
    return DynamicGaussians(raw, motion)


def alpha(model: DynamicGaussians, time: float) -> Float32Array:
    return render(model.at(time), CAMERA, near=NEAR).alpha


def open_pixels(model: DynamicGaussians) -> NDArray[np.bool_]:
    return alpha(model, OPENED)[WITHIN] < COVERED


@pytest.mark.parametrize(("apart", "left"), [(5.0, 0.1), (30.0, 0.3)])
def test_what_opened_while_it_was_hidden_is_closed_in_the_colour_of_what_is_beside(
    apart: float, left: float
) -> None:
    before = sheet(apart)
    after = closed_gaps(before, frames(), NEAR)
    assert open_pixels(before).sum() > 50
    assert open_pixels(after).sum() < left * open_pixels(before).sum()
    drawn = render(after.at(OPENED), CAMERA, near=NEAR)
    np.testing.assert_allclose(drawn.image, drawn.alpha[..., None] * np.full(3, 0.5), atol=1e-5)


def test_what_is_visible_stays_as_it_was_trained() -> None:
    before = sheet()
    after = closed_gaps(before, frames(), NEAR)
    for name, own in before.raw.arrays().items():
        np.testing.assert_array_equal(after.raw.arrays()[name][: len(before)], own)
    assert np.abs(alpha(after, LATER) - alpha(before, LATER)).max() < 0.005


def test_tissue_without_gaps_stays() -> None:
    assert closed_gaps(before := sheet(0.0), frames(), NEAR) is before


def test_what_is_too_far_from_all_tissue_is_not_filled(monkeypatch: pytest.MonkeyPatch) -> None:
    before = sheet(30.0)
    assert (alpha(before, OPENED)[MIDDLE] < 0.001).any()
    monkeypatch.setattr(gaps, "WIDEST", 8.0)
    after = closed_gaps(before, frames(), NEAR)
    middle = slice(18, 30), slice(45, 48)  # Farther than that from both sides.
    np.testing.assert_array_equal(alpha(after, OPENED)[middle] < COVERED, True)


def test_of_many_pixels_that_are_as_clear_few_get_a_copy() -> None:
    clear = np.zeros((20, 25), np.float32)
    found = np.argwhere(_clearest(clear, clear == 0))
    assert len(found) == 20
    apart = np.abs(found[:, None] - found).max(axis=2)
    assert apart[apart > 0].min() == APART


def test_a_gap_that_frames_show_is_as_they_show_it() -> None:
    assert closed_gaps(before := sheet(), frames(hide=False), NEAR) is before


def test_what_few_frames_show_stays_open() -> None:
    def rarely(index: int, frame: TrainFrame) -> TrainFrame:
        mask = frame.color_mask.copy()
        mask[MIDDLE] &= index < 3
        return replace(frame, color_mask=mask)

    seldom = [rarely(index, frame) for index, frame in enumerate(frames())]
    assert closed_gaps(before := sheet(), seldom, NEAR) is before
