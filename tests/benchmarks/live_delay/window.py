"""The window with a live source: says where its picture is, and after so many seconds how it went."""

from __future__ import annotations

import json
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final

import psutil
from imgui_bundle import hello_imgui, immapp

from app.gui.actions import enhancement_actions, live_actions, presenting
from app.gui.drawing.textures import PLAIN, Marks, ShowsPictures
from app.gui.panels import picture_pane
from app.gui.state.app_state import AppState
from app.gui.style.widgets import Area
from app.gui.views.picture_view import PictureView
from app.gui.window import Window
from app.gui.work.settings import Places, Settings
from app.live.address import LiveAddress, LiveInput, address_of
from app.live.picture import LiveSetting
from app.live.session import LiveSession
from app.live.sources.source import Wish
from enhance import EnhanceParams, VesselParams
from renderer.clip import ByteImage
from tests.benchmarks.live_delay.painted import PaintedSource

METHODS: Final = {"paper": EnhanceParams(), "vessel": VesselParams()}
WARM: Final = 6.0
"""Seconds that are not counted: kernels are loaded, the layout settles."""
PAINTED: Final = "painted"
MEGABYTE: Final = 1 << 20


@dataclass(frozen=True)
class Trial:
    """One row of the table. As JSON, it is what this program is given."""

    clip: str
    kind: str
    """painted, or the address of a stream"""
    width: int
    height: int
    frames_per_second: float
    method: str
    alone: bool
    """The enhanced picture fills the window: no panels."""
    seconds: float


class Watch:
    """Counts frames and moves of the slider, and ends the window."""

    def __init__(self, state: AppState, trial: Trial, panes: Panes) -> None:
        self._state, self._trial, self._panes = state, trial, panes
        self._process = psutil.Process()
        self._began: float | None = None
        self._used = 0.0
        self._frames = self._moves = 0
        self._params: Any = None
        self._told = False
        self._dropped = self._arrived = 0
        self._memory = 0.0

    def after_swap(self) -> None:
        state, now = self._state, time.monotonic()
        status = state.live.status
        if not state.live.flows or status is None:
            return
        if self._began is None:
            self._began = now
        passed = now - self._began
        if passed < WARM:
            self._used, self._memory = sum(self._process.cpu_times()[:2]), self._resident()
            self._dropped, self._arrived = status.dropped, status.arrived
            if passed > WARM / 3 and self._params is None:
                self._params = state.enhancement.params
                if self._trial.alone:
                    presenting.show(state, "right")
            return
        if not self._told:
            say({"box": self._panes.box(state)})
            self._told = True
        self._frames += 1
        self._moves += state.enhancement.params != self._params
        self._params = state.enhancement.params
        if passed > WARM + self._trial.seconds:
            used = sum(self._process.cpu_times()[:2]) - self._used
            arrived = status.arrived - self._arrived
            say({
                "arrived": arrived, "dropped": status.dropped - self._dropped,
                "frames": self._frames, "moves": self._moves,
                "cores": used / self._trial.seconds, "memory": (self._memory, self._resident()),
                "to_ready": asdict(status.to_ready) if status.to_ready else None,
                "to_screen": asdict(status.to_screen) if status.to_screen else None,
            })  # fmt: skip
            hello_imgui.get_runner_params().app_shall_exit = True

    def _resident(self) -> float:
        return self._process.memory_info().rss / MEGABYTE


def say(what: dict[str, Any]) -> None:
    print(json.dumps(what), flush=True)


class Panes:
    """Where pictures were drawn last: each pane's place on the screen."""

    def __init__(self) -> None:
        self._areas: dict[str, Area] = {}
        self._draw = picture_pane.draw_part

    def watch(self) -> None:
        picture_pane.draw_part = self._draw_part

    def _draw_part(
        self,
        textures: ShowsPictures,
        slot: str,
        image: ByteImage,
        view: PictureView,
        area: Area,
        marks: Marks = PLAIN,
    ) -> None:
        self._areas[slot] = area
        self._draw(textures, slot, image, view, area, marks)

    def box(self, state: AppState) -> list[float]:
        """Left, top, width and height of the enhanced picture, in pixels."""
        assert state.live.clip is not None
        area, size = self._areas["right"], state.live.clip.size
        placed = state.picture.view.place(size, area.inside)
        left, top = placed.pane_at(0, 0)
        return [area.corner.x + left, area.corner.y + top, placed.zoom_x * size[0], placed.zoom * size[1]]


def run(trial: Trial, folder: Path) -> None:
    places = Places(folder / "config", folder / "runs", folder / "pictures")
    window = Window(AppState(places, Settings(acknowledged=True)))
    enhancement_actions.set_params(window.state, METHODS[trial.method])
    begin(window.state, trial)
    params, panes = window.runner_params(), Panes()
    params.ini_disable = True
    panes.watch()
    watch = Watch(window.state, trial, panes)
    shown = params.callbacks.after_swap

    def after_swap() -> None:
        shown()
        watch.after_swap()

    params.callbacks.after_swap = after_swap
    immapp.run(params, Window.add_ons())


def begin(state: AppState, trial: Trial) -> None:
    if trial.kind != PAINTED:
        live_actions.go_live(state, LiveInput(address_of(trial.kind)), Wish())
        return
    size = trial.width, trial.height
    source = partial(PaintedSource, Path(trial.clip), size, trial.frames_per_second)
    state.live.source = LiveInput(LiveAddress("file", "", PAINTED))
    setting = LiveSetting(state.enhancement.params)
    state.live.session = LiveSession(source, setting, on_picture=hello_imgui.request_refresh)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as given:
        run(Trial(**json.loads(sys.argv[1])), Path(given))
