"""The app with a person at it who does the same over and over, until somebody ends it.

`python -m tests.benchmarks.attack.window_work WORK [PATH]`: a line when the work begins, and for each thing
that the window says went wrong. "close" takes up what an earlier window left, and closes.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Final

from imgui_bundle import hello_imgui

import app.__main__
import app.gui.window
from app.gui.actions import (
    actions,
    batch_actions,
    enhancement_actions,
    export_actions,
    job_actions,
    notes_actions,
    preset_actions,
    recovering,
    session_actions,
)
from app.gui.state.app_state import AppState
from app.gui.state.exports import What
from app.gui.window import Window
from enhance import EnhanceParams
from renderer.train.config import TrainConfig

BEGINS = "begins"
FRAMES_PER_SECOND = 25.0
CONFIG = TrainConfig(iterations=3000, n_gaussians=80, checkpoint_every=50)
PICTURES: Final[tuple[What, ...]] = ("panes and 3D view", "both panes", "3D view")
SPANS: Final[tuple[What, ...]] = ("video of both panes", "video through time", "measures of both panes")
INPUTS = ("endonerf/images", "export.mp4", "picture.png")
"""Of the seeds: a folder, a video and a picture."""
LAST = 8
"""Frames that are drawn before the window closes by itself."""
Act = Callable[[AppState, int], None]
"""With the number of the frame, from the first in which there is everything to see."""


def save(state: AppState, frame: int) -> None:
    """Settings, presets and the session, on disk as fast as they go."""
    enhancement_actions.set_params(state, EnhanceParams(d_factor=0.1 + frame % 30 / 10))
    actions.remember_recent(state, not state.settings.remember_recent)
    preset_actions.keep(state, f"mine {frame % 5}")
    notes_actions.write_notes(state, f"{frame}\n" * (frame % 300))
    session_actions.save_to(state, state.places.pictures / "a.vesselsplat")


def export_picture(state: AppState, frame: int) -> None:
    """One after the other, beside those that are saved with S."""
    export_actions.export_request(state, PICTURES[frame % len(PICTURES)])
    if frame % 10 == 0:
        export_actions.save_picture(state)


def export_video(state: AppState, frame: int) -> None:
    export_actions.export_request(state, SPANS[frame % len(SPANS)])


def train(state: AppState, frame: int) -> None:
    """One run after the other; what they show is drawn."""
    if not state.runs.reconstruction.is_alive and not state.runs.queue:
        state.runs.reconstruction.config = CONFIG
        job_actions.start_reconstruction(state)


def enhance(state: AppState, frame: int) -> None:
    for name in INPUTS:
        batch_actions.add_input(state, _seeds(state) / name)
    batch_actions.batch_request(state)


def _seeds(state: AppState) -> Path:
    assert state.source.path is not None
    return state.source.path.parent


ACTS: Final[dict[str, Act]] = {
    "save": save, "picture": export_picture, "video": export_video, "train": train, "enhance": enhance,
}  # fmt: skip


class Attended(Window):
    """The window with that person at it."""

    def __init__(self, state: AppState, act: Act | None) -> None:
        super().__init__(state)
        self._act, self._frame = act, 0
        self._told = False

    def runner_params(self) -> hello_imgui.RunnerParams:
        params = super().runner_params()
        advance = params.callbacks.pre_new_frame

        def attended() -> None:
            advance()
            self._attend()

        params.callbacks.pre_new_frame = attended
        return params

    def _attend(self) -> None:
        hello_imgui.get_runner_params().fps_idling.fps_idle = FRAMES_PER_SECOND
        state = self.state
        if state.window.banner is not None and not self._told:
            self._told = True
            print(f"banner: {state.window.banner.message}", flush=True)
        if self._act is None:
            self._close()
        elif self._frame or _all_is_seen(state):
            if self._frame == 0:
                print(BEGINS, flush=True)
            self._act(state, self._frame)
            self._frame += 1

    def _close(self) -> None:
        recovering.recover(self.state)
        if self.state.source.opening is None:
            self._frame += 1
        if self._frame == LAST:
            hello_imgui.get_runner_params().app_shall_exit = True


def _all_is_seen(state: AppState) -> bool:
    source, pictures = state.source, state.picture.pictures
    return source.opening is None and pictures is not None and state.scene.view is not None


def main() -> int:
    """As `python -m app [PATH]`."""
    act = ACTS.get(sys.argv[1])
    app.gui.window.Window = lambda state: Attended(state, act)  # type: ignore[assignment, misc]
    return app.__main__.main(sys.argv[2:])


if __name__ == "__main__":
    sys.exit(main())
