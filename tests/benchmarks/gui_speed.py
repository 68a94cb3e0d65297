"""How quick the window is: first frame, idle share, memory; frames and slider to picture, also under a job.

xvfb-run -a python -m tests.benchmarks.gui_speed CLIP [--train]
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import psutil
from imgui_bundle import hello_imgui, imgui, immapp
from imgui_bundle.immapp import testing

from app.gui.actions import actions, enhancement_actions, job_actions
from app.gui.state.app_state import AppState
from app.gui.window import Window
from app.gui.work.settings import Places, Settings
from enhance import EnhanceParams

MOVES = 60
IDLE = (8.0, 16.0)
"""Seconds after the start between which the idle share is taken."""
MEGABYTE = 1 << 20
Context = imgui.test_engine.TestContext


def main(clip: Path, *, train: bool) -> None:
    print(f"{clip.name}, load {os.getloadavg()[0]:.1f} at the start")
    alone_in_its_process(clip)
    with tempfile.TemporaryDirectory() as folder:
        drag(make_window(clip, Path(folder)), train=train)


def alone_in_its_process(clip: Path) -> None:
    """The second start: Python's bytecode is kept by then, as it is wherever the app is installed."""
    command = [sys.executable, "-m", "tests.benchmarks.gui_speed", str(clip), "--alone"]
    with tempfile.TemporaryDirectory() as bytecode:
        kept = os.environ | {"PYTHONDONTWRITEBYTECODE": "", "PYTHONPYCACHEPREFIX": bytecode}
        subprocess.run(command, check=True, env=kept, stdout=subprocess.DEVNULL)
        subprocess.run(command, check=True, env=kept)


def make_window(clip: Path, folder: Path) -> Window:
    places = Places(folder / "config", folder / "runs", folder / "pictures")
    window = Window(AppState(places, Settings(acknowledged=True)))
    actions.open_path(window.state, clip)
    return window


def alone(clip: Path) -> None:
    """A process of its own, left alone: first frame, idle share of one core, memory."""
    process, began = psutil.Process(), time.monotonic()
    seen: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        params = make_window(clip, Path(folder)).runner_params()

        def look() -> None:
            now = time.monotonic() - began
            seen.setdefault("first", time.time() - process.create_time())
            if now > IDLE[0]:
                seen.setdefault("from", now)
                seen["frames"] = seen.get("frames", 0) + 1
                seen.setdefault("used", sum(process.cpu_times()[:2]))
            if now > IDLE[1]:
                share = (sum(process.cpu_times()[:2]) - seen["used"]) / (now - seen["from"])
                memory = process.memory_info().rss / MEGABYTE
                rate = seen["frames"] / (now - seen["from"])
                print(f"first frame {seen['first']:.2f} s, memory {memory:.0f} MB")
                print(f"idle: {100 * share:.1f} % of a core at {rate:.1f} frames/s")
                hello_imgui.get_runner_params().app_shall_exit = True

        params.callbacks.before_swap = look
        immapp.run(params, Window.add_ons())


class Hand:
    """On a slider: when it moved, and how long its picture took to be on screen."""

    def __init__(self, state: AppState) -> None:
        self._state = state
        self._chosen: EnhanceParams | None = None
        self._began: float | None = None
        self.waited: float | None = None
        """Seconds; None while the picture has not come."""

    def take_hold(self, params: hello_imgui.RunnerParams) -> None:
        """Of the panel with the sliders."""
        windows = params.docking_params.dockable_windows
        panel = next(window for window in windows if window.label == "Enhancement")
        draw = panel.gui_function

        def draw_moved() -> None:
            if self._began is not None and self._chosen is not None:
                enhancement_actions.set_params(self._state, self._chosen)
            draw()

        panel.gui_function = draw_moved

    def move(self, chosen: EnhanceParams) -> None:
        self._chosen, self._began, self.waited = chosen, None, None

    def after_swap(self, now: float) -> None:
        if self._chosen is None or self.waited is not None:
            return
        if self._began is None:
            self._began = now
        elif (
            self._state.picture.pictures is not None
            and self._state.picture.pictures.request.params == self._chosen
        ):
            self.waited = now - self._began


def drag(window: Window, *, train: bool) -> None:
    """Moves z as a hand on a slider does, each time after the picture before is on screen.

    The hand moves when a frame has just been shown; the next one finds the slider moved where it draws it.
    """
    state, swaps, waits = window.state, [], []
    hand = Hand(state)
    params = window.runner_params()
    params.ini_disable = True
    hand.take_hold(params)

    def after_swap() -> None:
        swaps.append(time.perf_counter())
        hand.after_swap(swaps[-1])

    params.callbacks.after_swap = after_swap

    def drive(ctx: Context) -> None:
        wait(ctx, lambda: state.picture.pictures is not None and state.picture.pictures.enhanced is not None)
        if train:
            job_actions.start_reconstruction(state)
            wait(ctx, lambda: state.runs.reconstruction.progress is not None)
        for warm in (0.21, 0.22, 0.23):
            move(ctx, warm)
        swaps.clear()
        waits.extend(move(ctx, 0.3 + 0.005 * step) for step in range(MOVES))
        job_actions.cancel(state)
        wait(ctx, lambda: not state.runs.reconstruction.is_alive)

    def move(ctx: Context, z: float) -> float:
        hand.move(EnhanceParams(z=z))
        wait(ctx, lambda: hand.waited is not None)
        assert hand.waited is not None
        return hand.waited

    testing.run(test_function=drive, runner_params=params, add_ons_params=window.add_ons())
    under = "under a job" if train else "without a job"
    for name, values in (("frame", np.diff(swaps)), ("slider to picture", np.array(waits))):
        middle, most = (1000 * np.percentile(values, share) for share in (50, 95))
        print(f"{name} {under}: median {middle:.1f} ms, p95 {most:.1f} ms of {len(values)}")


def wait(ctx: Context, until: object) -> None:
    end = time.monotonic() + 120
    while not until():  # type: ignore[operator]
        if time.monotonic() > end:
            raise TimeoutError("the window did not answer within two minutes")
        ctx.yield_()


if __name__ == "__main__":
    given = Path(sys.argv[1])
    if "--alone" in sys.argv:
        alone(given)
    else:
        main(given, train="--train" in sys.argv)
