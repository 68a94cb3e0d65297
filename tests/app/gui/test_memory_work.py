"""What was open before gives its memory back: once, and never while pictures are being made."""

from __future__ import annotations

from pathlib import Path

from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels, Row
from app.gui.update.wishes import REST
from app.gui.work.tidying import OnScreen
from enhance import EnhanceParams
from renderer.clip import Clip
from tests.app.gui.conftest import make_clip
from tests.app.gui.test_update import settle


def tidying() -> Row[OnScreen, None]:
    channels = Channels()
    (row,) = (row for row in channels.rows if row.channel is channels.tidying)
    return row


def test_once_for_everything_that_comes_to_rest(state: AppState, clip: Clip, tmp_path: Path) -> None:
    settle(state, Channels())
    work = tidying()
    work.ask(state)
    assert work.channel.asked is None
    state.window.now = state.picture.asked_at + REST
    work.ask(state)
    assert work.channel.asked == OnScreen(state.source.path, clip)
    assert work.channel.run_waiting()
    state.window.now += 100
    work.ask(state)
    assert not work.channel.run_waiting()
    state.source.clip = make_clip(tmp_path / "another")
    settle(state, Channels())
    state.window.now = state.picture.asked_at + REST
    work.ask(state)
    assert work.channel.run_waiting()


def test_not_while_a_picture_is_awaited(state: AppState) -> None:
    settle(state, Channels())
    actions.set_params(state, EnhanceParams(z=0.0))
    state.window.now = state.picture.asked_at + 100
    work = tidying()
    work.ask(state)
    assert work.channel.asked is None
