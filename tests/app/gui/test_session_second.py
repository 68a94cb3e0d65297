"""What is in the second 3D view is kept in a session."""

from __future__ import annotations

import json
import shutil

from app.gui.actions import second_actions, session_actions
from app.gui.actions.session_actions import snapshot
from app.gui.work.settings import Places
from assets import phantom_path
from renderer.gaussians import DynamicGaussians
from tests.app.gui.test_opening import make_run
from tests.app.gui.test_session import opened_state, turn


def test_the_second_view_comes_back(places: Places, model: DynamicGaussians) -> None:
    first, beside = (make_run(places.runs / name, phantom_path(), model) for name in ("first", "beside"))
    state, channels = opened_state(places, first.path)
    second_actions.open_second(state, beside.path)
    for _ in range(4):
        turn(state, channels)
    path = places.pictures / "two.vesselsplat"
    session_actions.save_to(state, path)
    turn(state, channels)
    turn(state, channels)
    assert not state.session.is_unsaved
    assert json.loads(path.read_text())["second"]["sha256"] is not None
    other, channels = opened_state(places, path)
    for _ in range(4):
        turn(other, channels)
    assert other.scene.second.model is not None
    assert other.scene.second.model.path == beside.path
    assert snapshot(other, path.parent) == snapshot(state, path.parent)
    second_actions.close_second(other)
    turn(other, channels)
    turn(other, channels)
    assert other.session.is_unsaved
    shutil.rmtree(beside.path)
    other, channels = opened_state(places, path)
    assert other.scene.model is not None
    assert other.scene.second.model is None
    assert other.window.banner is None
    assert any("beside is no longer there" in line for line in other.window.log)
