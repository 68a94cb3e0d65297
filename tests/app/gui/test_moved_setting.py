"""A setting moved under the hand is on screen in the frame that moved it."""

from __future__ import annotations

from typing import Any

import pytest
from imgui_bundle import imgui

from app.gui import window
from app.gui.actions import actions, enhancement_actions
from app.gui.panels.compare import draw_compare
from app.gui.panels.enhancement import draw_enhancement
from app.gui.state.app_state import AppState
from app.gui.update import update
from app.gui.work.settings import Places
from assets import phantom_path
from enhance import EnhanceParams
from tests.app.gui.driver import Driver, is_settled, wait

MOVED = [EnhanceParams(z=z) for z in (0.3, 0.4, 0.5)]


@pytest.mark.display
def test_the_picture_of_a_moved_setting_is_in_the_same_frame(
    places: Places, monkeypatch: pytest.MonkeyPatch
) -> None:
    moves: list[tuple[object, int]] = []
    """A setting, and the frame in which it was chosen."""
    drawn: list[tuple[object, int]] = []
    """The setting of the pictures that were drawn, and in which frame."""

    def move(state: AppState, *rest: Any) -> None:
        draw_enhancement(state, *rest)
        if is_settled(state) and len(moves) < len(MOVED):
            moves.append((MOVED[len(moves)], imgui.get_frame_count()))
            enhancement_actions.set_params(state, MOVED[len(moves) - 1])

    def look(state: AppState, *rest: Any) -> None:
        if state.picture.pictures is not None:
            drawn.append((state.picture.pictures.request.params, imgui.get_frame_count()))
        draw_compare(state, *rest)

    monkeypatch.setattr(window, "draw_enhancement", move)
    monkeypatch.setattr(window, "draw_compare", look)
    monkeypatch.setattr(update, "PROMPT", 5.0)  # A slow machine is not what is tried.
    driver = Driver(places)

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        actions.open_path(driver.state, phantom_path())
        wait(ctx, lambda: len(moves) == len(MOVED), "all moves")
        ctx.yield_()

    driver.run(drive)
    assert set(moves) <= set(drawn)
