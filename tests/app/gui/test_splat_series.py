"""A folder of numbered splat files in the window: stepped, scrubbed and played as a clip is."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.gui.actions import actions, camera_actions, export_actions
from app.gui.panels.timeline import draw_timeline
from app.gui.state.app_state import AppState
from app.gui.state.exports import What
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.gui.work.beside import BesideRequest, find_models
from app.gui.work.recents import RecentsRequest, find_recents
from app.gui.work.settings import Places, Settings
from renderer.splat_files import write_splats
from tests.app.gui.settling import settle
from tests.app.gui.ui import Shown, Ui
from tests.renderer.test_splat_series import at


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Four moments, each of another number of Gaussians."""
    path = tmp_path / "moments"
    path.mkdir()
    for index in range(4):
        write_splats(path / f"{index:03d}.ply", at(0.1 * index, 5 + index))
    return path


@pytest.fixture
def shown(places: Places, folder: Path) -> AppState:
    state = AppState(places, Settings(acknowledged=True))
    actions.open_path(state, folder)
    settle(state, Channels())
    return state


def seen(state: AppState) -> int:
    """Gaussians at the moment that is shown."""
    assert state.scene.model is not None
    return len(state.scene.model.model.at(state.time))


@pytest.mark.parametrize("what", ["page for browsers", "surface through time", "surface of all frames"])
def test_what_needs_one_model_says_so(shown: AppState, what: What) -> None:
    assert "splat file per moment" in export_actions.why_not_export(shown, what)
    assert "surface" not in camera_actions.choices(shown)


def test_it_is_stepped_and_scrubbed(ui: Ui, shown: AppState) -> None:
    assert (shown.moments, seen(shown)) == (4, 5)
    actions.step(shown, 1)
    assert (shown.moment, seen(shown)) == (1, 6)
    actions.step(shown, 10)
    assert seen(shown) == 8
    actions.go_to_end(shown, last=False)
    assert seen(shown) == 5

    def draw() -> None:
        draw_timeline(shown, Shown())

    # From the left to the right end of the strip above the slider.
    ui.drag(draw, (200, 25), (700, 25))
    assert (shown.moment, seen(shown)) == (3, 8)


def test_it_is_played_round_and_round(shown: AppState) -> None:
    channels, counts = Channels(), []
    actions.toggle_play(shown)
    for tick in range(12):
        update(shown, channels, 10 + 0.1 * tick)
        counts.append(seen(shown))
    assert set(counts) == {5, 6, 7, 8}
    actions.toggle_play(shown)
    update(shown, channels, 20.0)
    assert seen(shown) == counts[-1]


def test_what_needs_one_model_that_moves_is_not_offered(shown: AppState) -> None:
    assert "motion" not in camera_actions.choices(shown)
    assert shown.editing.base is None


def test_it_is_a_model_among_what_was_opened_lately(shown: AppState, folder: Path, tmp_path: Path) -> None:
    (found,) = find_models(BesideRequest((str(folder), str(tmp_path)), ""))
    assert found == (folder,)
    *_, recents = find_recents(RecentsRequest((str(folder),), tmp_path / "small"))
    assert recents[str(folder)].kind == "splats"
