"""Two windows of one person keep what they remember in the same files."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.gui.actions import actions, clip_actions
from app.gui.state.app_state import AppState
from app.gui.state.source import Source
from app.gui.update.channels import Channels
from app.gui.work.settings import RECENT_LIMIT, Places, Settings, load_clips, load_settings
from app.runs.clip_selection import ClipPart
from renderer.clip import Clip
from tests.app.gui.conftest import make_clip
from tests.app.gui.settling import keep_all


@pytest.fixture
def windows(places: Places) -> tuple[AppState, AppState]:
    first = AppState(places, Settings(acknowledged=True, recent=("/old",)))
    actions.resize_text(first, 1)
    keep_all(first)
    return (
        AppState(places, load_settings(places.settings_file)),
        AppState(places, load_settings(places.settings_file)),
    )


def opens(state: AppState, path: str) -> None:
    actions.use_settings(state, state.settings.opened(Path(path)).visited("file", Path(path).parent))
    keep_all(state)


def test_what_each_has_changed_is_kept(windows: tuple[AppState, AppState], places: Places) -> None:
    one, other = windows
    actions.choose_theme(one, "light")
    opens(one, "/a/one.mp4")
    actions.choose_background(other, "black")
    opens(other, "/b/other.mp4")
    kept = load_settings(places.settings_file)
    assert (kept.theme, kept.background, kept.text_percent) == ("light", "black", 110)
    assert set(kept.recent) == {"/a/one.mp4", "/b/other.mp4", "/old"}
    assert kept.recent[0] == "/b/other.mp4"
    assert kept.folders == {"file": "/b"}


def test_the_newest_of_both_are_remembered(windows: tuple[AppState, AppState], places: Places) -> None:
    for place in range(RECENT_LIMIT):
        for name, state in zip("ab", windows, strict=True):
            opens(state, f"/{name}/{place}")
    kept = load_settings(places.settings_file).recent
    assert len(kept) == RECENT_LIMIT
    assert {f"/a/{RECENT_LIMIT - 1}", f"/b/{RECENT_LIMIT - 1}"} <= set(kept)


def test_what_one_has_forgotten_the_other_does_not_bring_back(
    windows: tuple[AppState, AppState], places: Places
) -> None:
    one, other = windows
    actions.remember_recent(one, False)
    keep_all(one)
    opens(other, "/patient/clip.mp4")
    kept = load_settings(places.settings_file)
    assert (kept.remember_recent, kept.recent, kept.folders) == (False, (), {})
    assert not other.settings.remember_recent
    # Nor later, unless a person asks for it there.
    opens(other, "/patient/again.mp4")
    assert load_settings(places.settings_file) == kept
    actions.remember_recent(other, True)
    opens(other, "/phantom")
    assert load_settings(places.settings_file).recent == ("/phantom",)


def test_a_list_that_is_switched_off_and_on_before_an_answer_is_on(
    windows: tuple[AppState, AppState], places: Places
) -> None:
    state = windows[0]
    for remember in (False, True):
        actions.remember_recent(state, remember)
    keep_all(state)
    assert load_settings(places.settings_file).remember_recent
    assert state.settings.remember_recent
    assert not state.window.log
    # Nor does an answer to what was asked for before count.
    actions.remember_recent(windows[1], False)
    keep_all(windows[1])
    actions.choose_theme(state, "light")
    for remember in (False, True):
        actions.remember_recent(state, remember)
    keep_all(state)
    assert load_settings(places.settings_file).remember_recent
    assert state.settings.remember_recent


def test_a_file_that_was_removed_is_written_whole(windows: tuple[AppState, AppState], places: Places) -> None:
    places.settings_file.unlink()
    opens(windows[0], "/new")
    assert load_settings(places.settings_file) == windows[0].settings


def test_a_write_that_failed_is_made_up_for(windows: tuple[AppState, AppState], places: Places) -> None:
    state, kept = windows[0], places.settings_file.read_bytes()
    places.settings_file.unlink()
    places.settings_file.mkdir()
    channels = Channels()
    actions.choose_theme(state, "light")
    actions.choose_background(state, "black")
    channels.finish(state)
    places.settings_file.rmdir()
    places.settings_file.write_bytes(kept)
    actions.resize_text(state, 1)
    channels.finish(state)
    assert load_settings(places.settings_file) == state.settings
    assert (state.settings.theme, state.settings.background) == ("light", "black")


def test_changes_are_kept_that_come_before_an_answer(
    windows: tuple[AppState, AppState], places: Places
) -> None:
    state = windows[0]
    actions.choose_theme(state, "light")
    actions.choose_theme(state, "dark")
    actions.use_settings(state, state.settings.opened(Path("/a")))
    actions.use_settings(state, state.settings.moved(Path("/a"), None))
    keep_all(state)
    assert load_settings(places.settings_file) == state.settings == state.saved_settings
    assert (state.settings.theme, state.settings.recent) == ("dark", ("/old",))


def test_settings_of_both_clips_are_kept(
    windows: tuple[AppState, AppState], places: Places, tmp_path: Path
) -> None:
    clips = [make_clip(tmp_path / name) for name in ("one", "other")]
    for state, clip in zip(windows, clips, strict=True):
        trims(state, clip)
    parts = {path: known.part for path, known in load_clips(places.config).items()}
    assert parts == {str(clip.path): ClipPart(trim=(1, 2)) for clip in clips}


def test_no_clip_is_kept_once_the_other_window_remembers_none(
    windows: tuple[AppState, AppState], places: Places, tmp_path: Path
) -> None:
    one, other = windows
    actions.remember_recent(one, False)
    keep_all(one)
    assert other.settings.remember_recent
    trims(other, make_clip(tmp_path / "clip"))
    assert not load_clips(places.config)
    actions.remember_recent(other, False)
    actions.remember_recent(other, True)
    trims(other, make_clip(tmp_path / "clip"))
    assert load_clips(places.config)


def trims(state: AppState, clip: Clip) -> None:
    state.source = Source(path=clip.path, clip=clip)
    state.source.part = ClipPart(trim=(1, 2))
    clip_actions.keep_settings(state)
    keep_all(state)
