"""Bars that stay in the picture while the scene goes by are told from the scene."""

from __future__ import annotations

import cv2
import numpy as np

from renderer.poses.burned_in import burned_in_borders


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
