"""What training frames show, and specks at its edge."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from renderer.camera import Camera
from renderer.clip import Clip, Frame
from renderer.measuring.tissue_seen import (
    ALIKE,
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
WHOLE = np.ones(SHAPE, np.float32)
"""Alpha of a render without fill."""
FILL, TISSUE = np.array([255 * level for level in GREY]), np.array((160.0, 95.0, 60.0))


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
    assert specks(image(near, far, beyond, outside), WHOLE, SEEN, NOWHERE) == 2


def test_what_frames_show_is_no_speck() -> None:
    at, shown = (40, 75), NOWHERE.copy()
    shown[at] = True
    assert specks(image(at), WHOLE, SEEN, shown) == 0
    assert specks(image(at), WHOLE, SEEN, NOWHERE) == 1


def test_tissue_as_the_frame_itself_shows_it_is_no_speck(clip: Clip) -> None:
    """A vessel at the edge is one, in the frame as in the render, and a tool beside it shows no tissue."""
    frame, bright, dark, metal = clip.read_frame(0), (220, 150, 140), (150, 30, 40), (240, 240, 250)
    shape, column = frame.tissue_mask.shape, 40
    tissue = np.zeros(shape, bool)
    tissue[:, :column] = True
    seen = np.full((*shape, 3), metal, np.uint8)
    seen[:, :column], seen[30] = bright, dark
    render, solid = np.full((*shape, 3), bright, np.uint8), np.ones(shape, np.float32)
    render[30, column - 1] = render[30, column + 1] = dark  # As the frame shows it, a little beyond the edge.
    known = replace(frame, image=seen, tissue_mask=tissue)
    assert specks(render, solid, tissue, np.zeros(shape, bool)) == 2
    assert specks(render, solid, tissue, recorded(render, known)) == 0
    others = ((10, column - 1), dark), ((50, column - 1), metal), ((30, column + STRAYS), dark)
    for place, color in others:
        render[place] = color
        assert not recorded(render, known)[place]
    assert specks(render, solid, tissue, recorded(render, known)) == len(others)


PALE, HIDDEN = (230, 190, 195), (44, 60)
"""A spot of tissue, and where a tool has just covered it."""
STEEL = (20, 30, 140)
"""Of a tool."""


def spotted() -> Frame:
    """A training frame that shows the spot, with a tool of another colour beside it."""
    alpha = corner()
    shown, tissue = beside_fill(alpha, (HIDDEN, PALE)), alpha > 0.5
    steel = np.s_[HIDDEN[0] + 1 :, HIDDEN[1] + 1 :]
    shown[steel], tissue[steel] = STEEL, False
    return Frame(0, 0.0, shown, Camera(80.0, 80.0, 60.0, 40.0, 120, 80), tissue, tissue)


def counted(place: tuple[int, int], color: Sequence[int]) -> int:
    """Specks, with a dot of that colour, of a frame that hides the spot, which a training frame shows."""
    alpha = corner()
    drawn, bare = beside_fill(alpha, (place, color)), spotted()
    bare = replace(bare, image=beside_fill(corner()))
    return specks(drawn, alpha, corner() > 0.5, NOWHERE, iter((bare, spotted(), bare)))


@pytest.mark.parametrize("off", [(0, 0), (-STRAYS, 0), (0, STRAYS), (2, 2)])
def test_what_a_training_frame_shows_there_is_no_speck(off: tuple[int, int]) -> None:
    row, column = HIDDEN[0] + off[0], HIDDEN[1] + off[1]
    for levels in ((0, 0, 0), (ALIKE, -ALIKE, ALIKE)):
        assert counted((row, column), np.add(PALE, levels)) == 0


@pytest.mark.parametrize("channel", range(3))
@pytest.mark.parametrize("levels", [-ALIKE - 1, ALIKE + 1])
def test_a_colour_off_by_more_in_one_channel_is_a_speck(channel: int, levels: int) -> None:
    color = np.array(PALE)
    color[channel] += levels
    assert counted(HIDDEN, color) == 1


@pytest.mark.parametrize("color", [(250, 250, 250), (40, 200, 60), (0, 0, 0), (255, 95, 60), STEEL])
def test_dots_of_other_colours_in_that_very_place_are_specks(color: tuple[int, int, int]) -> None:
    """That of a tool, too: it is no tissue of the frame that shows it."""
    assert counted(HIDDEN, color) == 1


def test_that_colour_elsewhere_or_afloat_is_a_speck() -> None:
    beside, afloat = (HIDDEN[0] - STRAYS - 1, HIDDEN[1]), (36, 60)
    assert counted(beside, PALE) == 1
    assert counted(afloat, PALE) == 1
    shown = spotted()
    shown.image[afloat], shown.tissue_mask[afloat] = PALE, True
    alpha = corner()
    assert specks(beside_fill(alpha, (afloat, PALE)), alpha, corner() > 0.5, NOWHERE, (shown,)) == 1


def test_frames_are_read_only_where_there_is_something_to_look_up() -> None:
    def unread() -> Iterator[Frame]:
        raise AssertionError("read")
        yield

    alpha = corner()
    assert specks(beside_fill(alpha), alpha, alpha > 0.5, NOWHERE, unread()) == 0


def test_a_thin_part_that_was_not_observed_is_no_speck_but_colour_in_it_is() -> None:
    grey = np.full((*SHAPE, 3), 200, np.uint8)
    grey[38:41, 60:] = [round(255 * level) for level in GREY]
    assert specks(grey, WHOLE, SEEN, NOWHERE) == 0
    grey[39, 85] = (150, 40, 40)
    assert specks(grey, WHOLE, SEEN, NOWHERE) == 1


def test_the_soft_edge_of_what_was_not_observed_is_no_speck() -> None:
    grey, tissue = np.array([255 * level for level in GREY]), np.array((220.0, 140.0, 120.0))
    soft = np.tile(tissue, (*SHAPE, 1))
    # A finger three pixels wide, with a pixel on both sides that is half of it.
    for rows, share in ((slice(37, 42), 0.5), (slice(38, 41), 1.0)):
        soft[rows, 60:] = tissue + share * (grey - tissue)
    soft = np.rint(soft).astype(np.uint8)
    assert specks(soft, WHOLE, SEEN, NOWHERE) == 0
    for place, color in (((37, 70), (250, 250, 250)), ((37, 85), (0, 0, 0)), ((41, 90), (220, 140, 20))):
        soft[place] = color
    assert specks(soft, WHOLE, SEEN, NOWHERE) == 3


def beside_fill(alpha: np.ndarray, *dots: tuple[tuple[int, int], Sequence[int]]) -> np.ndarray:
    """Tissue of that alpha (H, W) over the fill, with opaque dots of other colours."""
    made = np.rint(FILL + alpha[..., None] * (TISSUE - FILL)).astype(np.uint8)
    for place, color in dots:
        made[place], alpha[place] = color, 1
    return made


def corner() -> np.ndarray:
    """(H, W) alpha of tissue in the lower left, up to row 40 and column 70, with an edge that is soft."""
    rows, columns = np.ogrid[: SHAPE[0], : SHAPE[1]]
    away = np.minimum(rows - 39, 70 - columns)
    return np.clip((away + 1) / 3, 0, 1).astype(np.float32)


def test_a_corner_of_tissue_beside_the_fill_is_no_speck() -> None:
    alpha = corner()
    seen = alpha > 0.5
    drawn = beside_fill(alpha)
    assert specks(drawn, alpha, seen, NOWHERE) == 0
    elsewhere = np.broadcast_to(np.arange(SHAPE[1]) < 55, SHAPE)
    assert specks(drawn, alpha, elsewhere, NOWHERE) > 0, "compared with what is around, fill and all"


@pytest.mark.parametrize("color", [(250, 250, 250), (40, 200, 60), (0, 0, 0), (255, 95, 60)])
@pytest.mark.parametrize("place", [(39, 71), (41, 69), (39, 50), (60, 71), (44, 66)])
def test_dots_of_other_colours_at_a_corner_or_edge_are_specks(
    place: tuple[int, int], color: tuple[int, int, int]
) -> None:
    alpha = corner()
    seen = alpha > 0.5
    assert specks(beside_fill(alpha, (place, color)), alpha, seen, NOWHERE) == 1


@pytest.mark.parametrize("place", [(36, 40), (34, 80), (50, 76), (60, 85)])
def test_tissue_that_floats_in_the_fill_is_a_speck_whatever_its_colour(place: tuple[int, int]) -> None:
    alpha = corner()
    seen = alpha > 0.5
    assert specks(beside_fill(alpha, (place, (160, 95, 60))), alpha, seen, NOWHERE) == 1


def test_tissue_that_hangs_out_far_is_a_speck_and_so_is_an_island() -> None:
    alpha = corner()
    seen = alpha > 0.5
    alpha[60, 70:84] = 1  # A strand one pixel wide, from the edge on.
    alpha[20:24, 40:44] = 1
    far = specks(beside_fill(alpha), alpha, seen, NOWHERE)
    assert far == (84 - 70 - STRAYS) + 16


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
    assert specks(ramp, WHOLE, SEEN, NOWHERE) == 0
