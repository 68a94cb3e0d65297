"""Bars that stay in the picture while the scene goes by are told from the scene."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from renderer.camera import Camera
from renderer.clip import Frame
from renderer.poses.burned_in import burned_in_borders, dark_bars


def views(*, step=7, top=0, bottom=0, left_tab=0):
    """Twelve views of 96x80 that slide over a rough scene with hard edges, behind bars of the picture."""
    rng = np.random.default_rng(0)
    rough = cv2.resize(rng.integers(60, 250, (30, 40), np.uint8), (400, 300), interpolation=cv2.INTER_NEAREST)
    for index in range(12):
        view = rough[3 * index : 3 * index + 80, step * index : step * index + 96].copy()
        view[:top], view[80 - bottom :] = 30, 25
        view[75:, 8 : 8 + left_tab] = 10
        yield np.repeat(view[:, :, None], 3, axis=2)


def test_bars_are_found_with_their_blur_and_nothing_is_where_none_are():
    assert burned_in_borders(views()) == (0, 0, 0, 0)
    left, top, right, bottom = burned_in_borders(views(top=5, bottom=3))
    assert (left, right) == (0, 0)
    assert 5 <= top <= 9
    assert 3 <= bottom <= 7


def test_a_mark_along_a_part_of_the_border_counts_too():
    assert burned_in_borders(views(left_tab=30))[3] >= 5


def test_what_is_too_little_to_tell_has_no_bars():
    assert burned_in_borders([]) == (0, 0, 0, 0)
    assert burned_in_borders([next(views(top=5))]) == (0, 0, 0, 0)
    assert burned_in_borders([np.zeros((4, 4, 3), np.uint8)] * 3) == (0, 0, 0, 0)


def at_rest(*, tissue=None, bars=lambda image, index: None, count=6, size=(200, 150)):
    """Frames of a camera at rest before rough tissue that stays, its edges hard, behind bars of the image."""
    width, height = size
    rough = cv2.resize(
        np.random.default_rng(1).integers(100, 250, (height // 10, width // 10), np.uint8),
        size,
        interpolation=cv2.INTER_NEAREST,
    )
    camera = Camera.from_fov(60, width, height)
    tissue = np.ones((height, width), bool) if tissue is None else tissue
    for index in range(count):
        image = rough.copy()
        bars(image, index)
        yield Frame(index, index / count, np.repeat(image[..., None], 3, axis=2), camera, tissue, tissue)


def slanted(image, index):
    image[-1, 30:120] = image[-2, 30:60] = 40
    image[-2, 60:90] = 90


def test_thin_dark_bars_at_a_border_are_found_with_their_blur():
    assert dark_bars(at_rest(bars=slanted)) == (0, 0, 0, 3)

    def all_around(image, index):
        image[:2], image[-1:], image[:, :3], image[:, -1:] = 8, 9, 10, 11

    assert dark_bars(at_rest(bars=all_around)) == (4, 3, 2, 2)


def test_tissue_in_shadow_is_no_bar():
    assert dark_bars(at_rest()) == (0, 0, 0, 0)

    def falls_off(image, index):  # To a fifth at the border, over 40 pixels, and black in the corners.
        rows, columns = np.ogrid[: image.shape[0], : image.shape[1]]
        away = np.minimum(rows, np.minimum(columns, image.shape[0] - 1 - rows))
        image[:] = image * np.clip(0.2 + away / 50, 0, 1)
        image[:4, :15] = 5

    def farther_in(image, index):  # A vessel along the border, and tissue beyond it.
        image[-3:-1] = 20

    def wide(image, index):
        image[-12:] = 20

    def short(image, index):
        image[-2:, 50:68] = 20

    for shadow in (falls_off, farther_in, wide, short):
        assert dark_bars(at_rest(bars=shadow)) == (0, 0, 0, 0), shadow.__name__


def test_what_is_lit_in_one_frame_or_seen_in_few_is_no_bar():
    def goes(image, index):
        slanted(image, index)
        if index == 4:
            image[-2:] = 130

    def behind_a_dark_tool(image, index):
        slanted(image, index)
        if index != 4:
            image[-8:] = 15

    assert dark_bars(at_rest(bars=goes)) == (0, 0, 0, 0)
    assert dark_bars(at_rest(bars=behind_a_dark_tool)) == (0, 0, 0, 0)


def test_where_masks_or_dark_tools_hide_it_now_and_then_a_bar_stays_one():
    masked = np.ones((150, 200), bool)
    masked[-30:, 80:] = False

    def under_a_dark_tool(image, index):
        slanted(image, index)
        if index == 4:
            image[-8:] = 15

    assert dark_bars(at_rest(bars=under_a_dark_tool)) == (0, 0, 0, 3)
    assert dark_bars(at_rest(bars=slanted, tissue=masked)) == (0, 0, 0, 3)
    assert dark_bars(at_rest(bars=slanted, tissue=~masked)) == (0, 0, 0, 2)
    masked[-30:, 20:] = False
    assert dark_bars(at_rest(bars=slanted, tissue=masked)) == (0, 0, 0, 0)


def test_too_few_frames_or_such_of_several_sizes_have_no_dark_bars():
    assert dark_bars([]) == (0, 0, 0, 0)
    assert dark_bars(at_rest(bars=slanted, count=1)) == (0, 0, 0, 0)
    assert dark_bars([*at_rest(bars=slanted), *at_rest(bars=slanted, size=(100, 80))]) == (0, 0, 0, 0)
    (tiny,) = at_rest(size=(40, 20), count=1)
    tiny = replace(
        tiny,
        image=tiny.image[:2],
        tissue_mask=tiny.tissue_mask[:2],
        camera=tiny.camera.resized(40, 2),
        evaluation_mask=tiny.evaluation_mask[:2],
    )
    assert dark_bars([tiny] * 3) == (0, 0, 0, 0)
