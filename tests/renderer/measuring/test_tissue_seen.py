"""What training frames show, and specks at its edge."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from renderer.clip import Clip, Frame
from renderer.measuring.tissue_seen import (
    NEAR,
    STRAYS,
    highlights,
    recorded,
    seldom_seen,
    shares_seen,
    specks,
)
from renderer.phantom import PhantomParams, write_phantom
from renderer.sources import open_clip
from renderer.unobserved import GREY

SHAPE = (80, 120)
SEEN = np.ones(SHAPE, bool)
SEEN[:, 80:] = False


@pytest.fixture
def clip(tmp_path: Path) -> Clip:
    write_phantom(tmp_path / "clip", PhantomParams(n_frames=6, width=96, height=72))
    return open_clip(tmp_path / "clip")


def image(*places: tuple[int, int]) -> np.ndarray:
    """Grey, with a bright red pixel at each place."""
    made = np.full((*SHAPE, 3), 90, np.uint8)
    for place in places:
        made[place] = 250, 40, 40
    return made


def test_shares_count_the_frames_that_show_tissue(clip: Clip) -> None:
    shown = [clip.read_frame(index).tissue_mask for index in (0, 2, 3)]
    shares = shares_seen(clip, (0, 2, 3))
    assert shares is not None
    np.testing.assert_allclose(shares, np.mean(shown, axis=0))
    assert 0 < shares.min() + shares.max() <= 2
    np.testing.assert_array_equal(seldom_seen(clip, (0, 2, 3)), (shares > 0) & (shares <= 0.3))


def test_a_pixel_is_no_place_where_the_camera_moves(clip: Clip) -> None:
    moved = replace(clip, cameras=(replace(clip.cameras[0], cx=3.0), *clip.cameras[1:]))
    assert shares_seen(moved, (0, 2)) is None
    assert seldom_seen(moved, (0, 2)) is None


NOWHERE = np.zeros(SHAPE, bool)


def test_specks_are_counted_on_both_sides_of_the_edge_and_nowhere_else() -> None:
    near, far = (20, 80 - NEAR + 2), (20, 80 - NEAR - 4)
    beyond, outside = (50, 80 + NEAR - 3), (50, 80 + NEAR + 4)
    assert specks(image(near, far, beyond, outside), SEEN, NOWHERE) == 2


def test_what_frames_show_is_no_speck() -> None:
    at, shown = (40, 75), NOWHERE.copy()
    shown[at] = True
    assert specks(image(at), SEEN, shown) == 0
    assert specks(image(at), SEEN, NOWHERE) == 1


def test_tissue_as_the_frame_itself_shows_it_is_no_speck(clip: Clip) -> None:
    """A vessel at the edge is one, in the frame as in the render, and a tool beside it shows no tissue."""
    frame, bright, dark, metal = clip.read_frame(0), (220, 150, 140), (150, 30, 40), (240, 240, 250)
    shape, column = frame.tissue_mask.shape, 40
    tissue = np.zeros(shape, bool)
    tissue[:, :column] = True
    seen = np.full((*shape, 3), metal, np.uint8)
    seen[:, :column], seen[30] = bright, dark
    render = np.full((*shape, 3), bright, np.uint8)
    render[30, column - 1] = render[30, column + 1] = dark  # As the frame shows it, a little beyond the edge.
    known = replace(frame, image=seen, tissue_mask=tissue)
    assert specks(render, tissue, np.zeros(shape, bool)) == 2
    assert specks(render, tissue, recorded(render, known)) == 0
    others = ((10, column - 1), dark), ((50, column - 1), metal), ((30, column + STRAYS), dark)
    for place, color in others:
        render[place] = color
        assert not recorded(render, known)[place]
    assert specks(render, tissue, recorded(render, known)) == len(others)


def test_a_thin_part_that_was_not_observed_is_no_speck_but_colour_in_it_is() -> None:
    grey = np.full((*SHAPE, 3), 200, np.uint8)
    grey[38:41, 60:] = [round(255 * level) for level in GREY]
    assert specks(grey, SEEN, NOWHERE) == 0
    grey[39, 85] = (150, 40, 40)
    assert specks(grey, SEEN, NOWHERE) == 1


def test_the_soft_edge_of_what_was_not_observed_is_no_speck() -> None:
    grey, tissue = np.array([255 * level for level in GREY]), np.array((220.0, 140.0, 120.0))
    soft = np.tile(tissue, (*SHAPE, 1))
    # A finger three pixels wide, with a pixel on both sides that is half of it.
    for rows, share in ((slice(37, 42), 0.5), (slice(38, 41), 1.0)):
        soft[rows, 60:] = tissue + share * (grey - tissue)
    soft = np.rint(soft).astype(np.uint8)
    assert specks(soft, SEEN, NOWHERE) == 0
    for place, color in (((37, 70), (250, 250, 250)), ((37, 85), (0, 0, 0)), ((41, 90), (220, 140, 20))):
        soft[place] = color
    assert specks(soft, SEEN, NOWHERE) == 3


def test_highlights_are_those_of_tissue_in_any_frame_and_what_lies_beside_them(clip: Clip) -> None:
    lit, on_tool = (30, 40), (50, 20)

    def read_frame(index: int) -> Frame:
        frame = clip.read_frame(index)
        dark, tissue = np.full_like(frame.image, 60), np.ones(frame.tissue_mask.shape, bool)
        tissue[on_tool] = False
        if index == 2:
            dark[lit] = dark[on_tool] = 255
        return replace(frame, image=dark, tissue_mask=tissue)

    lamps = replace(clip, read_frame=read_frame)
    found = highlights(lamps, (0, 2, 3))
    rows, columns = np.nonzero(found)
    assert found[lit]
    assert (np.hypot(rows - lit[0], columns - lit[1]) <= STRAYS + 0.5).all()
    assert not highlights(lamps, (0, 3)).any()


def test_a_smooth_fill_has_no_specks() -> None:
    ramp = np.broadcast_to(np.linspace(0, 255, SHAPE[1]).astype(np.uint8)[None, :, None], (*SHAPE, 3))
    assert specks(ramp, SEEN, NOWHERE) == 0
