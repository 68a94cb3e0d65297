"""Trim and mask of a clip: what they leave out, and that they are there the next time."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydantic import TypeAdapter

from app.enhancement.frame_enhancer import PictureMaker
from app.enhancement.image_mask import NO_MASK, PictureMask, enclosing
from app.gui.actions import actions, arriving, clip_actions
from app.gui.state.app_state import AppState
from app.gui.state.panes import pane, tinted
from app.gui.state.source import Source
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.gui.views.picture_view import Placement
from app.gui.views.resample import TINT, Patch
from app.gui.views.resample import tinted as tint
from app.gui.work import masking
from app.gui.work.opening import Opened
from app.gui.work.settings import FILE, MOST_CLIPS, KnownClip, Places, clips_content, load_clips
from app.gui.work.strip import DAMAGED, HEIGHT, MOST, StripRequest, count_for, make_strip
from app.runs.clip_selection import ClipPart
from renderer.clip import ByteImage, Clip, ClipError
from tests.app.gui.conftest import image_of, make_clip
from tests.app.gui.settling import keep_all, served


def settle(state: AppState, channels: Channels, now: float) -> None:
    for _ in range(6):
        update(state, channels, now)
        for channel in (*served(channels), *channels.of("second")):
            while channel.run_waiting():
                pass


def test_a_box_leaves_out_and_a_circle_keeps() -> None:
    kept = PictureMask(text=(2, 1, 5, 3), view=(4.0, 4.0, 3.5)).kept((8, 8))
    assert not kept[1:3, 2:5].any()
    assert not kept[0, 0]
    assert kept[4, 4]
    assert NO_MASK.kept((3, 4)).all()


def test_drawing_goes_from_any_corner_and_from_the_middle() -> None:
    mask = NO_MASK.drawn("text", (5, 3), (2, 1)).drawn("view", (4, 4), (7, 8))
    assert mask == PictureMask(text=(2, 1, 5, 3), view=(4, 4, 5))


@pytest.mark.parametrize("end", [(60.0, 40.0), (50.0, 54.2)])
def test_a_circle_of_pixels_that_are_not_square_is_round_on_screen(end: tuple[float, float]) -> None:
    """Drawn as far to the right as down, of pixels 1.42 times as wide as high."""
    mask = NO_MASK.drawn("view", (50.0, 40.0), end, 1.42)
    assert mask.view == pytest.approx((50, 40, 14.2, 1.42))
    rows, columns = np.nonzero(mask.kept((80, 100)))
    assert (np.ptp(rows) + 1, np.ptp(columns) + 1) == (28, 20)
    found = enclosing(mask.kept((80, 100)), 1.42)
    assert found == pytest.approx((50, 40, 14.2, 1.42), abs=0.6)
    assert TypeAdapter(PictureMask).validate_json(TypeAdapter(PictureMask).dump_json(mask)) == mask


def test_the_circle_of_a_round_view_is_found() -> None:
    keep = PictureMask(view=(50.0, 40.0, 30.0)).kept((80, 100))
    found = enclosing(keep)
    assert found is not None
    np.testing.assert_allclose(found, (50, 40, 30), atol=0.6)
    cut = enclosing(keep & (np.arange(100) < 65))
    assert cut is not None
    np.testing.assert_allclose(cut, (50, 40, 30), atol=0.6)
    assert enclosing(np.ones((4, 4), bool)) is None
    assert enclosing(np.zeros((4, 4), bool)) is None


def test_masked_pixels_do_not_count(state: AppState) -> None:
    """The dark vessel, masked by a box, no longer moves the mean saturation; the picture stays whole."""

    def statistics() -> tuple[float, float]:
        assert state.picture_request is not None
        used = list(PictureMaker().make(state.picture_request))[-1].statistics
        assert used is not None
        return used.level, used.saturation_mean

    before = statistics()
    clip_actions.set_mask(state, PictureMask(text=(10, 0, 14, 40)))
    level, saturation = statistics()
    tissue = (190 - 100) / 190
    assert saturation == pytest.approx(tissue, abs=1e-4)
    assert level == 190
    assert before != (level, saturation)
    clip_actions.set_mask(state, PictureMask(text=(-1, -1, 99, 99)))
    assert statistics() == before  # With nothing left, all count.


def test_pooled_statistics_keep_to_the_trim(state: AppState, clip: Clip) -> None:
    read: list[int] = []
    state.source.clip = make_clip(clip.path)
    object.__setattr__(
        state.source.clip, "read_image", lambda index: (read.append(index), image_of(index))[1]
    )
    state.enhancement.scope = "clip"
    actions.seek(state, 2)
    clip_actions.trim_here(state, start=True)
    actions.seek(state, 4)
    clip_actions.trim_here(state, start=False)
    assert state.source.span == (2, 4)
    assert state.picture_request is not None
    list(PictureMaker().make(replace(state.picture_request, of_clip=None)))
    assert set(read) == {2, 3, 4}


def test_playing_goes_round_within_the_trim(state: AppState) -> None:
    channels = Channels()
    state.source.part = ClipPart(trim=(1, 3))
    settle(state, channels, 0.0)
    actions.toggle_play(state)
    seen = []
    for step in range(1, 9):
        settle(state, channels, now := 0.1 * step)
        update(state, channels, now)
        seen.append(state.timeline.frame_index)
    assert set(seen) == {1, 2, 3}


def test_an_end_before_the_start_takes_that_back_to_the_first_frame(state: AppState) -> None:
    actions.seek(state, 4)
    clip_actions.trim_here(state, start=True)
    actions.seek(state, 1)
    clip_actions.trim_here(state, start=False)
    assert state.source.span == (0, 1)
    clip_actions.untrim(state)
    assert state.source.span == (0, 5)
    assert ClipPart(trim=(7, 9)).span(6) == (5, 5)
    assert ClipPart(trim=(0, 99)).span(6) == (0, 5)


def test_they_are_there_when_the_clip_is_opened_again(state: AppState, places: Places, clip: Clip) -> None:
    clip_actions.set_mask(state, PictureMask(view=(20, 20, 18)))
    clip_actions.finish_mask(state)
    actions.seek(state, 2)
    clip_actions.trim_here(state, start=True)
    said = state.source.part
    keep_all(state)
    again = AppState(places, source=Source(known=load_clips(places.config)))
    arriving.show_opened(again, clip.path, Opened(clip))
    assert again.source.part == said
    other = make_clip(clip.path.with_name("other"))
    arriving.show_opened(again, other.path, Opened(other))
    assert again.source.part == ClipPart()


def test_a_damaged_file_is_no_obstacle_and_the_file_stays_small(places: Places) -> None:
    places.config.mkdir(parents=True)
    (places.config / FILE).write_text("{ no")
    assert load_clips(places.config) == {}
    many = {f"clip {index}": KnownClip(trim=(0, index)) for index in range(MOST_CLIPS + 5)}
    (places.config / FILE).write_bytes(clips_content({"untouched": KnownClip(), **many}))
    there = load_clips(places.config)
    assert len(there) == MOST_CLIPS
    assert f"clip {MOST_CLIPS + 4}" in there
    assert "untouched" not in there


def test_nothing_is_written_where_paths_are_not_remembered(state: AppState, places: Places) -> None:
    actions.remember_recent(state, False)
    clip_actions.trim_here(state, start=True)
    actions.seek(state, 3)
    clip_actions.trim_here(state, start=True)
    assert not (places.config / FILE).exists()


def test_the_strip_shows_frames_in_order_and_has_a_bound(clip: Clip) -> None:
    assert count_for(clip, 1e6, 10) == len(clip)
    assert count_for(make_clip(Path("long"), 1000), 1e6, 10) == MOST
    assert count_for(clip, 1, 10) == 1
    *_, strip = make_strip(StripRequest(clip, 3))
    assert strip.image.shape[0] == HEIGHT
    width = strip.image.shape[1] // 3
    vessels = [int(strip.image[30, place * width : (place + 1) * width, 1].argmin()) for place in range(3)]
    assert vessels == sorted(vessels)
    assert vessels[0] < vessels[2]


def test_a_frame_that_cannot_be_read_is_grey_in_the_strip_and_the_rest_follows(clip: Clip) -> None:
    def read(index: int) -> ByteImage:
        if index == 3:
            raise ClipError("frame 3 is damaged")
        return image_of(index)

    *_, strip = make_strip(StripRequest(replace(clip, read_image=read), len(clip)))
    tiles = np.split(strip.image, len(clip), axis=1)
    grey = [(np.ptp(tile, axis=2) == 0).all() and (tile == DAMAGED).mean() > 0.5 for tile in tiles]
    assert grey == [index == 3 for index in range(len(clip))]


def test_a_strip_of_few_frames_keeps_their_shape_and_place(clip: Clip) -> None:
    *_, strip = make_strip(StripRequest(clip, 2))
    width = 40 * clip.size[0] / clip.size[1]
    (first, second) = strip.edges(1000, 40)
    for (left, right), middle in ((first, 250), (second, 750)):
        assert right - left == pytest.approx(width, rel=0.02)
        assert (left + right) / 2 == pytest.approx(middle)
    assert strip.edges(10, 40) == [(0, 5), (5, 10)]


def test_the_tint_is_where_pixels_are_left_out_and_only_while_it_is_asked_for(state: AppState) -> None:
    channels = Channels()
    clip_actions.set_mask(state, PictureMask(text=(0, 0, 10, 40)))
    settle(state, channels, 0.0)
    assert tinted(state) is None
    clip_actions.toggle_overlay(state)
    settle(state, channels, 0.1)
    left_out = tinted(state)
    assert left_out is not None
    assert left_out[:, :10].all()
    assert not left_out[:, 10:].any()
    assert state.picture.pictures is not None
    assert any("TINTED" in tag.text for tag in pane(state, state.picture.pictures, "right").tags)
    patch = Patch(image_of(0), 0, 0)
    painted = tint(patch, left_out, Placement(1.0, 0.0, 0.0), (48.0, 40.0)).pixels
    np.testing.assert_array_equal(painted[:, 10:], image_of(0)[:, 10:])
    moved = np.abs(painted[:, :10].astype(int) - TINT) < np.abs(image_of(0)[:, :10].astype(int) - TINT)
    assert moved.all()
    actions.seek(state, 2)
    update(state, channels, 0.2)
    assert tinted(state) is None  # Of another frame.


def test_a_tint_that_cannot_be_made_is_told_as_one(state: AppState, monkeypatch: pytest.MonkeyPatch) -> None:
    def damaged(clip: Clip, index: int) -> None:
        raise ClipError("frame 1 is damaged")

    monkeypatch.setattr(masking, "found_around", damaged)
    clip_actions.toggle_overlay(state)
    settle(state, Channels(), 0.0)
    assert state.window.log[-1] == "areas left out of this frame cannot be shown: frame 1 is damaged"
