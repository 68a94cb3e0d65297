"""A window that takes up damaged sessions one after the other, and is used a little with each.

`python -m tests.benchmarks.attack.session_window SEEDS FIRST LAST`: a line of JSON for each session that it
begins, and for each failure.
"""

from __future__ import annotations

import ctypes
import faulthandler
import json
import logging
import shutil
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import glfw
from imgui_bundle import hello_imgui
from imgui_bundle.immapp import testing

from app.__main__ import keep_quiet
from app.errors import UserError
from app.gui.actions import (
    actions,
    camera_actions,
    edit_actions,
    path_actions,
    session_actions,
    tuning_actions,
)
from app.gui.frame import dockings
from app.gui.session_file import SESSION
from app.gui.state.app_state import AppState
from app.gui.window import Window
from app.gui.work.settings import Places, Settings
from enhance import ImageError
from renderer.clip import ClipError
from tests.benchmarks.attack.session_mutations import damaged_session
from tests.benchmarks.person import Context, quieten

SECONDS = 10.0
"""For one session to be taken up, drawn and used."""
FRAMES = 4
EXPECTED = (UserError, ClipError, ImageError, OSError)
"""Lines for the banner."""


class Ended(Exception):
    """No frames are drawn any more: what ended them is raised where the window runs."""


class Attacked:
    """The window, and what goes wrong in it."""

    def __init__(self, seeds: Path, scratch: Path) -> None:
        self.folder = scratch / "all"
        shutil.copytree(seeds, self.folder)
        self.content = (seeds / "a.vesselsplat").read_bytes()
        places = Places(scratch / "config", scratch / "runs", scratch / "pictures")
        for path in vars(places).values():
            path.mkdir()
        self.state = AppState(places, Settings(acknowledged=True))
        self.window = Window(self.state)
        self.number = -1
        self.frames = 0

    def watch(self) -> None:
        """Exceptions of threads and of the worker that no person is told in a line of ours; OpenGL errors."""
        handler = logging.Handler()
        handler.emit = self._note  # type: ignore[method-assign]
        for name, level in (("", logging.WARNING), ("app.gui.work.background", logging.DEBUG)):
            logging.getLogger(name).addHandler(handler)
            logging.getLogger(name).setLevel(level)
        threading.excepthook = lambda given: self.tell("thread", given.exc_value)
        sys.unraisablehook = lambda given: self.tell("ignored", given.exc_value)

    def _note(self, record: logging.LogRecord) -> None:
        error = record.exc_info[1] if record.exc_info else None
        if not isinstance(error, EXPECTED):
            self.tell(record.getMessage(), error)

    def tell(self, where: str, error: BaseException | None = None) -> None:
        last, trace = "", error.__traceback__ if error is not None else None
        while trace is not None:
            last, trace = f"{Path(trace.tb_frame.f_code.co_filename).name}:{trace.tb_lineno}", trace.tb_next
        said = f"{where}: {type(error).__name__}: {error} ({last})" if error is not None else where
        print(json.dumps({"number": self.number, "error": said[:300]}), flush=True)

    def params(self) -> hello_imgui.RunnerParams:
        """The window's own; what its panels raise is told before the runner, which is left in the middle of a
        panel, ends the process."""
        params = self.window.runner_params()
        params.ini_disable = True
        params.callbacks.before_swap = self.after_frame
        for name in ("pre_new_frame", "show_menus", "show_status", "post_render_dockable_windows"):
            setattr(params.callbacks, name, self._telling(getattr(params.callbacks, name)))
        panels = params.docking_params.dockable_windows
        for panel in panels:
            panel.gui_function = self._telling(panel.gui_function)
        params.docking_params.dockable_windows = panels
        return params

    def _telling(self, draw: Callable[[], None]) -> Callable[[], None]:
        def drawn() -> None:
            try:
                draw()
            except Exception as error:
                self.tell("drawing", error)
                raise

        return drawn

    def after_frame(self) -> None:
        """In the window's thread, where its OpenGL context is."""
        self.frames += 1
        get_error = ctypes.CFUNCTYPE(ctypes.c_uint)(glfw.get_proc_address("glGetError"))
        for _ in range(8):
            if (code := get_error()) == 0:
                break
            self.tell(f"OpenGL error 0x{code:04x}")

    # ---- one session

    def take_up(self, ctx: Context, number: int) -> None:
        """Open it, see it, use it, keep it; whatever state the one before has left."""
        self.number = number
        print(json.dumps({"begins": number}), flush=True)
        state, path = self.state, self.folder / f"{number}.vesselsplat"
        path.write_bytes(damaged_session(self.content, number))
        state.window.banner = None
        actions.open_path(state, path)
        if state.editing.leaving is not None:
            edit_actions.answer(state, "discard")
        if state.session.leaving is not None:
            session_actions.answer(state, "discard")
        end = time.monotonic() + SECONDS
        self._wait(ctx, lambda: state.source.opening is None, end, "it to open")
        print(json.dumps({"taken": state.session.path == path}), flush=True)
        self._wait(ctx, self._is_seen, end, "its pictures")
        for act in self._acts(number):
            act(state)
            self._frames(ctx, FRAMES)
        self._wait(ctx, self._is_seen, end, "its pictures, used")
        SESSION.validate_python(SESSION.dump_python(session_actions.snapshot(state, self.folder)))
        for left in self.folder.glob(f"{number}.vesselsplat*"):
            left.unlink()

    def _is_seen(self) -> bool:
        state = self.state
        return state.source.clip is None or (state.picture.pictures is not None and not state.pictures_wait)

    def _acts(self, number: int) -> list[Callable[[AppState], None]]:
        """All panels in turn, and what may meet a value that was taken up."""
        every: list[Callable[[AppState], None]] = [
            path_actions.toggle_path, tuning_actions.start_grid, actions.toggle_play,
            lambda state: camera_actions.zoom(state, 1.2), lambda state: camera_actions.turn(state, 0.2, 0.1),
            lambda state: camera_actions.pan(state, 20, 10), actions.toggle_freeze, path_actions.add_keyframe,
            path_actions.save_view, lambda state: actions.seek_view(state, 0.9), actions.toggle_link,
            lambda state: dockings.toggle("Notes"), lambda state: dockings.toggle("Log"),
            camera_actions.toggle_snap, lambda state: actions.step(state, 1), tuning_actions.toggle_tuning,
            lambda state: actions.choose_text_size(state, 110 if number % 4 else 100), edit_actions.toggle,
            lambda state: actions.choose_theme(state, "light" if number % 2 else "dark"),
        ]  # fmt: skip
        return [lambda state: None, *(every[(number + step) % len(every)] for step in (0, 5, 11))]

    def _wait(self, ctx: Context, until: Callable[[], bool], end: float, what: str) -> None:
        while not until():
            if time.monotonic() > end:
                self.tell(f"hangs: {SECONDS:.0f} s have not been enough for {what}")
                return
            self._frames(ctx, 1)
            time.sleep(0.005)
        self._frames(ctx, FRAMES)

    def _frames(self, ctx: Context, count: int) -> None:
        before = self.frames
        ctx.yield_(count)
        if self.frames == before:
            raise Ended


def main() -> None:
    """See the module."""
    faulthandler.enable()
    keep_quiet()
    seeds, first, last = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    with tempfile.TemporaryDirectory() as scratch:
        attacked = Attacked(seeds, Path(scratch))
        attacked.watch()

        def drive(ctx: Context) -> None:
            quieten(ctx)
            with suppress(Ended):
                for number in range(first, last):
                    attacked.take_up(ctx, number)
                print(json.dumps({"done": True}), flush=True)

        try:
            testing.run(
                test_function=drive, runner_params=attacked.params(), add_ons_params=attacked.window.add_ons()
            )
        except BaseException as error:
            attacked.tell("the window ended", error)
            sys.exit(1)


if __name__ == "__main__":
    main()
