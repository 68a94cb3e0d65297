"""What a user works with is there again at the next start."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.gui.actions import actions, arriving, comparing, enhancement_actions, history_actions, remembered
from app.gui.state.app_state import AppState
from app.gui.state.choosing import Kind
from app.gui.work.keeping import KeepSettings
from app.gui.work.opening import Opened
from app.gui.work.settings import load_settings
from assets import phantom_path
from enhance import EnhanceParams
from enhance.vessel import VesselParams
from renderer.sources import open_clip
from tests.app.gui.conftest import make_clip
from tests.app.gui.settling import keep_all


@pytest.fixture
def begun(state: AppState) -> AppState:
    """A first start."""
    remembered.begin(state)
    return state


def next_start(state: AppState) -> AppState:
    """Another window, after this one has kept what it should."""
    remembered.remember(state)
    keep_all(state)
    later = AppState(state.places, load_settings(state.places.settings_file))
    remembered.begin(later)
    return later


def test_a_first_window_opens_with_vessels_and_nothing_to_undo(begun: AppState) -> None:
    assert begun.enhancement.params == VesselParams()
    history_actions.undo(begun)
    assert begun.enhancement.params == VesselParams()
    remembered.remember(begun)
    assert not begun.window.wishes  # Nothing has changed that would have to be kept.


def test_method_statistics_pixels_and_comparison_come_back(begun: AppState) -> None:
    enhancement_actions.choose_method(begun, EnhanceParams)
    enhancement_actions.choose_scope(begun, "image")
    enhancement_actions.choose_pixels(begun, "all")
    comparing.choose_mode(begun, "wipe")
    later = next_start(begun)
    chosen = later.enhancement
    assert (chosen.params, chosen.scope, chosen.pixels) == (EnhanceParams(), "image", "all")
    assert later.comparing.chosen.mode == "wipe"
    assert len(chosen.past) == 1
    assert chosen.past == [later.chosen]


def test_no_window_opens_with_differences(begun: AppState) -> None:
    comparing.choose_mode(begun, "difference")
    assert next_start(begun).comparing.chosen.mode == "side by side"


def test_parameters_start_at_the_standard_of_their_method(begun: AppState) -> None:
    enhancement_actions.set_params(begun, VesselParams(strength=4.0))
    assert next_start(begun).enhancement.params == VesselParams()


def test_what_is_undone_or_reset_does_not_come_back(begun: AppState) -> None:
    enhancement_actions.choose_method(begun, EnhanceParams)
    enhancement_actions.settle_params(begun)
    history_actions.undo(begun)
    enhancement_actions.choose_pixels(begun, "all")
    enhancement_actions.reset_params(begun)
    later = next_start(begun).enhancement
    assert (later.params, later.pixels) == (VesselParams(), "automatic")


def test_dialogs_begin_beside_what_was_opened_last_however_that_was(begun: AppState, tmp_path: Path) -> None:
    clip = make_clip(tmp_path / "study" / "dropped")
    arriving.show_opened(begun, clip.path, Opened(clip))
    (written,) = (wish for wish in begun.window.wishes if isinstance(wish, KeepSettings))
    assert written.settings.recent == (str(clip.path),)
    assert set(written.settings.folders) == {"file", "folder"}
    # Neither lies where a person keeps clips.
    arriving.show_opened(begun, phantom_path(), Opened(open_clip(phantom_path())))
    arriving.show_opened(begun, begun.places.runs / "run-1", Opened(clip))
    kinds: tuple[Kind, ...] = ("file", "folder")
    for state in (begun, next_start(begun)):
        for kind in kinds:
            actions.choose_path(state, kind)
            assert (choosing := actions.taken_choice(state)) is not None
            assert choosing.start == tmp_path / "study"
