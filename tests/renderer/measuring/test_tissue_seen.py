"""What training frames show, and specks at its edge."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from renderer.clip import Clip
from renderer.measuring.tissue_seen import NEAR, seldom_seen, shares_seen, specks
from renderer.phantom import PhantomParams, write_phantom
from renderer.sources import open_clip

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


def test_specks_are_counted_on_both_sides_of_the_edge_and_nowhere_else() -> None:
    near, far = (20, 80 - NEAR + 2), (20, 80 - NEAR - 4)
    beyond, outside = (50, 80 + NEAR - 3), (50, 80 + NEAR + 4)
    assert specks(image(near, far, beyond, outside), image(), SEEN, SEEN) == 2


def test_a_highlight_of_the_frame_itself_is_no_speck() -> None:
    at = (40, 75)
    assert specks(image(at), image(at), SEEN, SEEN) == 0
    assert specks(image(at), image(at), np.zeros(SHAPE, bool), SEEN) == 1


def test_a_smooth_fill_has_no_specks() -> None:
    ramp = np.broadcast_to(np.linspace(0, 255, SHAPE[1]).astype(np.uint8)[None, :, None], (*SHAPE, 3))
    assert specks(ramp, image(), SEEN, SEEN) == 0
