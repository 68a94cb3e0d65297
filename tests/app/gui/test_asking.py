"""Questions: Enter gives the safe reply, nothing below stays in focus; an earlier session is offered."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from imgui_bundle import imgui

from app.gui.panels import overlays
from app.gui.state.app_state import AppState
from app.gui.style.asking import ask
from tests.app.gui.ui import Draw, Ui


@pytest.fixture
def keys(ui: Ui) -> Ui:
    ui.io.config_flags |= imgui.ConfigFlags_.nav_enable_keyboard
    return ui


def enter(ui: Ui, draw: Draw) -> None:
    for _ in range(3):
        ui.frame(draw)
    ui.press(draw, imgui.Key.enter)
    ui.frame(draw)


def test_of_several_replies_it_is_the_last(keys: Ui) -> None:
    replies: list[str] = []

    def draw() -> None:
        imgui.button("below")
        if not replies and (reply := ask("Delete?", ("It is lost.",), ("Delete", "Keep"))):
            replies.append(reply)

    enter(keys, draw)
    assert replies == ["Keep"]
    assert not keys.io.nav_visible


def test_what_was_lost_is_restored(keys: Ui, state: AppState, tmp_path: Path) -> None:
    state.session.recoverable = tmp_path / "autosave-1.vesselsplat"
    state.session.recoverable.touch()
    enter(keys, lambda: overlays.draw_recovery(state))
    assert state.session.recoverable is None
    assert state.source.opening is not None


def test_the_notice_is_understood(keys: Ui, state: AppState) -> None:
    state.settings = replace(state.settings, acknowledged=False)
    enter(keys, lambda: overlays.draw_notice(state))
    assert state.settings.acknowledged


def test_an_earlier_session_is_offered_where_there_is_one(ui: Ui, state: AppState, tmp_path: Path) -> None:
    for found in (None, tmp_path / "autosave-1.vesselsplat"):
        state.session.recoverable = found
        ui.frame(lambda: overlays.draw_recovery(state))
        offer = imgui.internal.find_window_by_name(overlays.OFFER)
        assert (offer is not None and offer.active) == (found is not None)
