"""Masks learned from those that a person has drawn: of tools that colour alone does not find."""

from __future__ import annotations

import numpy as np
import pytest

from renderer.clip import BoolImage, ByteImage
from renderer.tools.learning import Example, LearnedTools, learned_well
from renderer.tools.search import find_tools

WIDTH, HEIGHT = 320, 240
ALL = np.ones((HEIGHT, WIDTH), bool)


def frame(left: int, seed: int, blue: float = 0.0) -> tuple[ByteImage, BoolImage]:
    """Pale tissue with a bar of copper that no rule of colour takes for steel, from column `left` on."""
    random = np.random.default_rng(seed)
    image = np.array((190, 120, 110)) * np.linspace(0.6, 1.1, WIDTH)[None, :, None]
    tool = np.zeros((HEIGHT, WIDTH), bool)
    tool[90:140, left : left + 120] = True
    image = np.where(tool[:, :, None], np.array((150, 90, 40 + blue)), image)
    return np.clip(image + random.normal(0, 4, image.shape), 0, 255).astype(np.uint8), tool


def iou(one: BoolImage, other: BoolImage) -> float:
    return float(np.count_nonzero(one & other) / max(np.count_nonzero(one | other), 1))


def test_what_one_frame_teaches_finds_the_tool_elsewhere() -> None:
    image, tool = frame(0, 1)
    learned = LearnedTools.of([Example.of(image, tool, ALL)])
    other, moved = frame(150, 2)
    assert not find_tools(other, ALL).any()
    assert iou(learned.find(other, ALL), moved) > 0.9
    large = np.repeat(np.repeat(other, 3, axis=0), 3, axis=1)
    found = learned.find(large, np.ones(large.shape[:2], bool))
    assert iou(found[1::3, 1::3], moved) > 0.9


def test_nothing_is_found_in_the_surround_or_on_bare_tissue() -> None:
    image, tool = frame(0, 1)
    learned = LearnedTools.of([Example.of(image, tool, ALL)])
    seen = ALL.copy()
    seen[:, 200:] = False
    other, _ = frame(150, 2)
    assert not learned.find(other, seen)[:, 200:].any()
    bare, _ = frame(WIDTH, 3)
    assert not learned.find(bare, ALL).any()


@pytest.mark.parametrize("tool", [np.zeros((HEIGHT, WIDTH), bool), ALL])
def test_frames_of_one_kind_alone_teach_nothing(tool: BoolImage) -> None:
    image, _ = frame(0, 1)
    example = Example.of(image, tool, ALL)
    assert LearnedTools.of([example]).network is None
    assert not LearnedTools.of([example]).find(image, ALL).any()
    assert LearnedTools.of([]).network is None


def test_how_well_is_measured_on_frames_that_taught_nothing() -> None:
    alike = [Example.of(*frame(left, left), ALL) for left in (0, 90, 180)]
    assert (learned_well(alike) or 0) > 0.85
    image, tool = frame(0, 1)
    # What is drawn on one frame contradicts the other: no skill, and the measure says so.
    wrong = Example.of(image, np.roll(tool, 100, axis=0), ALL)
    assert (learned_well([Example.of(image, tool, ALL), wrong]) or 0) < 0.2


def test_one_frame_or_none_with_a_tool_has_no_measure() -> None:
    image, tool = frame(0, 1)
    assert learned_well([Example.of(image, tool, ALL)]) is None
    assert learned_well([Example.of(image, np.zeros_like(tool), ALL)] * 2) is None


def test_tiny_frames_are_no_trouble() -> None:
    image = np.full((6, 9, 3), 120, np.uint8)
    tool = np.zeros((6, 9), bool)
    tool[:, :3] = True
    found = LearnedTools.of([Example.of(image, tool, np.ones((6, 9), bool))]).find(
        image, np.ones((6, 9), bool)
    )
    assert found.shape == (6, 9)
