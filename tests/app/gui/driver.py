"""The whole window under an X server, driven by the ImGui test engine."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from imgui_bundle import imgui
from imgui_bundle.immapp import testing

from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.window import Window
from app.gui.work.settings import Places, Settings
from tests.app.gui.conftest import FakeJob

SECONDS = 30.0
Drive = Callable[[imgui.test_engine.TestContext], None]
ACKNOWLEDGED = Settings(acknowledged=True)
"""Of all starts but the first."""


class Driver:
    """A small window that opens a path, and what a test does with it."""

    def __init__(self, places: Places, settings: Settings = ACKNOWLEDGED, opens: Path | None = None) -> None:
        self.jobs: list[FakeJob] = []
        """Those that the window has started."""
        self.state = AppState(places, settings)
        self.window = Window(self.state, self._make_job)
        if opens is not None:
            actions.open_path(self.state, opens)

    def _make_job(self, request: object) -> FakeJob:
        self.jobs.append(FakeJob(request))
        return self.jobs[-1]

    def run(self, drive: Drive) -> None:
        params = self.window.runner_params()
        params.ini_disable = True
        testing.run(test_function=drive, runner_params=params, add_ons_params=self.window.add_ons())


def wait(ctx: imgui.test_engine.TestContext, until: Callable[[], bool], what: str) -> None:
    end = time.monotonic() + SECONDS
    while not until():
        assert time.monotonic() < end, f"waited {SECONDS} s for {what}"
        ctx.yield_()
        time.sleep(0.03)  # Frames cost the processor as much as what is waited for.


def enhanced(state: AppState) -> np.ndarray:
    assert state.picture.pictures is not None
    assert state.picture.pictures.enhanced is not None
    return state.picture.pictures.enhanced


def is_settled(state: AppState) -> bool:
    """Both pictures are there, by the statistics of the clip."""
    done = state.picture.pictures is not None and state.picture.pictures.enhanced is not None
    wanted = state.picture_request
    return done and not state.pictures_are_stale and wanted is not None and wanted.of_clip != "later"
