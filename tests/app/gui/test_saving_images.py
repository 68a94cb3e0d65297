"""Images of what is shown, while they are still to be written: closing asks, none is lost silently."""

from __future__ import annotations

import numpy as np

from app.gui.actions import closing, export_actions, summary_actions, window_actions
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels
from app.gui.work.background import Failure


def write_all(state: AppState, channels: Channels) -> None:
    channels.ask_once(state)
    while channels.saving.run_waiting():
        pass
    while (taken := channels.saving.take()) is not None:
        summary_actions.take_saved(state, *taken)


def written(state: AppState) -> int:
    return len(list(state.export_folder.glob("*.png")))


def test_closing_asks_while_images_are_still_being_saved(opened: AppState) -> None:
    assert opened.source.clip is not None
    opened.source.clip.path.mkdir()
    channels = Channels()
    for _ in range(2):
        export_actions.save_picture(opened)
    export_actions.ask_image(opened, window_actions.window_request(opened, np.zeros((2, 2, 3), np.uint8)))
    channels.ask_once(opened)
    channels.saving.run_waiting()
    assert closing.at_stake(opened) == "3 images are still being saved."
    assert closing.what_is_kept(opened) == "Images not saved yet are lost."
    assert not closing.may_close(opened)
    write_all(opened, channels)
    assert written(opened) == 3
    assert closing.at_stake(opened) == closing.what_is_kept(opened) == ""
    summary_actions.add_shown(opened)
    assert closing.at_stake(opened) == "1 image is still being saved."
    (request,) = opened.exports.saving
    summary_actions.take_saved(opened, request, Failure(OSError("the disk is full")))
    assert not closing.at_stake(opened)


def test_more_images_than_can_wait_are_refused_aloud_and_the_page_is_not_locked(opened: AppState) -> None:
    assert opened.source.clip is not None
    opened.source.clip.path.mkdir()
    opened.enhancement.active = False
    channels, most = Channels(), export_actions.MOST_SAVING
    for _ in range(most):
        summary_actions.add_shown(opened)
    channels.ask_once(opened)
    assert opened.window.banner is None
    for act in (summary_actions.add_shown, export_actions.save_picture, export_actions.save_window):
        act(opened)
        assert opened.window.banner is not None
        assert f"{most} images are still being saved" in opened.window.banner.message
        opened.window.banner = None
    assert opened.exports.settling == 0
    write_all(opened, channels)
    assert written(opened) == most == len(opened.summary.items)
    assert opened.summary.awaited == ()
    assert summary_actions.why_not_write(opened) == summary_actions.why_not_add(opened) == ""
