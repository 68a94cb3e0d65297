"""Masks of neighbouring frames agree where both follow the tool."""

from __future__ import annotations

import numpy as np

from renderer.clip import BoolImage, ByteImage
from renderer.tools.agreement import WEAK, Agreement


def frame(left: int) -> tuple[ByteImage, BoolImage]:
    """A textured square on textured ground."""
    random = np.random.default_rng(0)
    ground, tool = random.integers(60, 110, (240, 320, 3)), np.zeros((240, 320), bool)
    square = random.integers(120, 250, (80, 80, 3))
    ground[80:160, left : left + 80], tool[80:160, left : left + 80] = square, True
    return ground.astype(np.uint8), tool


def test_a_mask_that_moves_with_the_tool_agrees() -> None:
    agreement = Agreement()
    assert agreement.with_next(*frame(100)) is None
    assert (agreement.with_next(*frame(108)) or 0) > 0.9


def test_a_mask_that_stays_behind_or_is_lost_does_not() -> None:
    for tool in (np.roll(frame(100)[1], 60, axis=1), np.zeros((240, 320), bool)):
        agreement = Agreement()
        agreement.with_next(*frame(100))
        score = agreement.with_next(frame(100)[0], tool)
        assert score is not None
        assert score < WEAK


def test_frames_without_tools_and_of_another_size_say_nothing() -> None:
    agreement, none = Agreement(), np.zeros((240, 320), bool)
    image, tool = frame(100)
    agreement.with_next(image, none)
    assert agreement.with_next(image, none) is None
    assert agreement.with_next(image[:, :200], tool[:, :200]) is None


def test_frames_too_thin_for_the_flow_say_nothing() -> None:
    agreement = Agreement()
    image, tool = frame(100)
    for _ in range(2):
        assert agreement.with_next(np.tile(image[100:104], (1, 2, 1)), np.tile(tool[100:104], (1, 2))) is None
