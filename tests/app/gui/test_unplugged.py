"""A drive that is unplugged while a clip plays, and comes back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.errors import UserError
from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels
from app.gui.update.update import update
from renderer.clip import Clip
from tests.app.gui.settling import settle


class Drive:
    """Frames that can be read as long as it is there."""

    def __init__(self, clip: Clip) -> None:
        self._read, self.there, self.reads = clip.read_image, True, 0

    def read(self, index: int) -> np.ndarray:
        self.reads += 1
        if not self.there:
            raise UserError(f"expected an image, got no such file: {index}.png")
        return self._read(index)


@pytest.fixture
def drive(state: AppState, channels: Channels, clip: Clip) -> Drive:
    """Unplugged before the second frame that plays is read."""
    drive = Drive(clip)
    state.source.clip = replace(clip, read_image=drive.read)
    settle(state, channels)
    drive.there = False
    actions.toggle_play(state)
    update(state, channels, 0.1)
    settle(state, channels, 0.1)
    return drive


def test_it_is_said_in_one_line_and_playing_stops(state: AppState, drive: Drive, channels: Channels) -> None:
    assert state.window.banner is not None
    assert state.window.banner.message == "expected an image, got no such file: 1.png"
    assert state.is_unreadable
    assert not state.timeline.playing
    reads = drive.reads
    settle(state, channels, 5.0)
    assert drive.reads == reads  # Not again and again by itself.


def test_playing_goes_on_once_it_is_back(state: AppState, drive: Drive, channels: Channels) -> None:
    drive.there = True
    actions.toggle_play(state)
    settle(state, channels, 0.2)
    assert not state.is_unreadable
    update(state, channels, 0.35)
    assert state.timeline.playing
    assert state.timeline.frame_index > 1


def test_it_is_said_again_where_it_is_still_gone(state: AppState, drive: Drive, channels: Channels) -> None:
    actions.dismiss(state)
    actions.toggle_play(state)
    settle(state, channels, 0.2)
    assert state.window.banner is not None
    assert not state.timeline.playing


def test_a_frame_that_is_come_back_to_is_read_again(
    state: AppState, drive: Drive, channels: Channels
) -> None:
    drive.there = True
    for frame in (2, 1):
        actions.seek(state, frame)
        settle(state, channels, 0.2)
    assert not state.is_unreadable
    assert state.picture.pictures is not None
    assert state.picture.pictures.request.frame_index == 1
