"""What will be left out is told before, and is what training then says."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from app.gui.state.app_state import AppState
from app.gui.update.update import Channels, update
from app.gui.work.omissions import Omissions, OmissionsRequest, look
from renderer.sources import open_clip
from renderer.train.config import TrainConfig
from renderer.train.events import Started
from renderer.train.trainer import train


def test_it_is_what_training_says_when_it_starts(clip_path: Path) -> None:
    clip = open_clip(clip_path)
    for config in (TrainConfig(iterations=1, n_gaussians=300), TrainConfig(method="static", iterations=1)):
        (told,) = look(OmissionsRequest(clip, replace(config, iterations=3000)))
        started = next(iter(train(clip, config)))
        assert isinstance(started, Started)
        assert told.omitted == started.omitted
        assert told.omitted


def test_it_is_looked_up_only_when_asked_for_and_not_for_more_iterations(
    state: AppState, clip_path: Path
) -> None:
    state.clip, channels = open_clip(clip_path), Channels()
    update(state, channels, 0.1)
    assert channels.omissions.asked is None
    state.asks_for_omissions = True
    update(state, channels, 0.2)
    first = channels.omissions.asked
    assert channels.omissions.run_waiting()
    update(state, channels, 0.3)
    assert isinstance(state.omissions, Omissions)
    state.reconstruction.config = replace(state.reconstruction.config, iterations=500)
    update(state, channels, 0.4)
    assert channels.omissions.asked is first
    state.reconstruction.config = replace(state.reconstruction.config, method="static")
    update(state, channels, 0.5)
    assert channels.omissions.asked != first
