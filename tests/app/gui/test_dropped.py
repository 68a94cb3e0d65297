"""Files, folders and what comes from a browser, dropped onto the window."""

from __future__ import annotations

from pathlib import Path

from app.gui.actions import actions, batch_actions, live_actions
from app.gui.state.app_state import AppState
from app.gui.work.settings import Places, Settings


def fresh(places: Places) -> AppState:
    return AppState(places, Settings(acknowledged=True))


def test_all_that_is_dropped_joins_the_batch_that_is_gathered_and_else_the_first_opens(
    places: Places, tmp_path: Path
) -> None:
    state, dropped = fresh(places), [tmp_path / "scope.mp4", tmp_path / "stills"]
    batch_actions.take_dropped(state, dropped)
    assert state.source.opening is not None
    assert state.source.opening.path == dropped[0]
    assert state.batches.inputs == ()
    actions.stop_opening(state)
    state.batches.shown = True
    batch_actions.take_dropped(state, dropped)
    assert state.batches.inputs == tuple(dropped)
    assert state.source.opening is None


def test_what_is_dropped_is_not_left_below_the_dialog_of_live_sources(places: Places, tmp_path: Path) -> None:
    state = fresh(places)
    live_actions.choose_source(state)
    batch_actions.take_dropped(state, [tmp_path / "scope.mp4"])
    assert state.source.opening is not None
    assert not state.live.choice.shown


def test_what_is_dropped_from_a_browser_is_told_from_a_file(places: Places, tmp_path: Path) -> None:
    state, address = fresh(places), Path("https://example.org/scope.png")
    for shown in (False, True):
        state.batches.shown, state.window.banner = shown, None
        batch_actions.take_dropped(state, [address])
        assert state.source.opening is None
        assert state.batches.inputs == ()
        assert state.window.banner is not None
        assert "got an address on the web" in state.window.banner.message
    batch_actions.take_dropped(state, [address, tmp_path / "scope.mp4"])
    assert state.batches.inputs == (tmp_path / "scope.mp4",)
