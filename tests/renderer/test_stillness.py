"""Displacement and change of colour: measured right where they are known, blind to lamp and highlights."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from renderer.clip import Frame
from renderer.phantom import Phantom, PhantomParams
from renderer.train.stillness import Stillness, stillness
from tests.renderer.plane import N_FRAMES, plane_clip


def measured(**changes: Any) -> Stillness:
    clip = plane_clip(**changes)
    return stillness([clip.read_frame(index) for index in range(N_FRAMES)])


@pytest.mark.parametrize("circle", [0.0, 3.0])
@pytest.mark.parametrize("slide", [0.2, 0.5, 1.0])
def test_a_known_displacement_is_measured(slide: float, circle: float) -> None:
    """The greatest between two frames compared: at most twice the slide, and more than the slide itself."""
    assert slide < measured(slide=slide, circle=circle).displacement < 2 * slide


@pytest.mark.parametrize("circle", [0.0, 3.0])
def test_tissue_at_rest_is_still_whoever_looks_at_it(circle: float) -> None:
    found = measured(circle=circle)
    assert found.displacement < 0.1
    assert found.recoloring < 0.2


@pytest.mark.parametrize("circle", [0.0, 3.0])
def test_lamp_and_highlights_change_colours_but_move_nothing(circle: float) -> None:
    found = measured(circle=circle, lamp=0.2, gloss=0.15)
    assert found.displacement < 0.35
    assert found.recoloring > 3


def test_noise_is_no_motion() -> None:
    """Where it hides the texture, it cannot be told whether anything moves."""
    assert measured(noise=2.0).displacement < 0.5
    assert measured(noise=2.0).recoloring < 0.5
    assert measured(noise=60.0).displacement == np.inf


def test_motion_of_a_part_is_enough() -> None:
    still, moving = plane_clip(), plane_clip(slide=1.5)

    def read(index: int) -> Frame:
        frame, other = still.read_frame(index), moving.read_frame(index)
        frame.image[:40, 48:] = other.image[:40, 48:]
        return frame

    assert stillness([read(index) for index in range(N_FRAMES)]).displacement > 1


def test_what_cannot_be_compared_is_not_still() -> None:
    """A moving camera without depth; a picture without texture; no tissue."""
    assert measured(circle=3.0, has_depth=False).displacement == np.inf
    assert measured(has_depth=False).displacement < 0.1
    clip = plane_clip()
    frames = [clip.read_frame(index) for index in range(N_FRAMES)]
    for frame in frames:
        frame.tissue_mask[:] = False
    assert stillness(frames) == Stillness(np.inf, np.inf)


def test_one_frame_is_still_and_two_are_compared() -> None:
    clip = plane_clip(slide=1.0)
    assert stillness([clip.read_frame(0)]) == Stillness(0.0, 0.0)
    assert stillness([clip.read_frame(0), clip.read_frame(2)]).displacement > 0.5


def test_pictures_too_small_for_a_block_of_colours_tell_nothing() -> None:
    phantom = Phantom(PhantomParams(n_frames=10, width=64, height=48, tissue="static"))
    assert stillness([phantom.view(index).frame for index in range(10)]) == Stillness(np.inf, np.inf)
