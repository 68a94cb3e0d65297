"""A person who drives the window by mouse and keys."""

from __future__ import annotations

import random
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from imgui_bundle import ImVec2, imgui

from app.gui.actions import actions, edit_actions, job_actions, session_actions, tuning_actions
from app.gui.state.app_state import AppState
from app.gui.window import Window
from app.gui.work.settings import Places

Context = imgui.test_engine.TestContext
UNPACED = FOREVER = 1e9
PATIENCE = 300.0
"""Seconds after which the window is said to hang."""
RESTING = 4.0
"""Seconds in which what waits for rest is done: measuring, and giving memory back a second after all work."""
KEEP_FILES = 12
K = imgui.Key


@dataclass
class Person:
    """Drives the window, not faster than `rate` acts a second."""

    ctx: Context
    window: Window
    clip: Path
    rng: random.Random
    rate: float
    acts: int = 0
    run: Path | None = None
    """A reconstruction of the clip that has been finished."""

    @property
    def state(self) -> AppState:
        return self.window.state

    @property
    def places(self) -> Places:
        return self.state.places

    # ---- the hand

    def pace(self) -> None:
        self.acts += 1
        self.ctx.yield_(2)
        time.sleep(1 / self.rate)

    def press(self, key: int) -> None:
        self.ctx.key_press(key)
        self.pace()

    def click(self, item: str) -> None:
        self.ctx.item_click(item)
        self.pace()

    def choose(self, panel: str, combo: str, entry: str) -> None:
        self.ctx.set_ref(self.ctx.window_info(panel).id_)
        self.ctx.combo_click(f"{combo}/{entry}")
        self.ctx.set_ref("")
        self.pace()

    def drag(self, item: str, start: tuple[float, float], end: tuple[float, float], button: int = 0) -> None:
        """From one point of an item to another, both in shares of its size."""
        box = self.ctx.item_info(item).rect_full
        size = (box.max.x - box.min.x, box.max.y - box.min.y)
        at = [ImVec2(box.min.x + x * size[0], box.min.y + y * size[1]) for x, y in (start, end)]
        self.ctx.mouse_move_to_pos(at[0])
        self.ctx.mouse_down(button)
        self.ctx.mouse_move_to_pos(at[1])
        self.ctx.mouse_up(button)
        self.pace()

    def wheel(self, item: str, steps: float) -> None:
        self.ctx.mouse_move(item)
        self.ctx.mouse_wheel_y(steps)
        self.pace()

    def wait(self, until: Callable[[], bool], what: str) -> None:
        end = time.monotonic() + PATIENCE
        while not until():
            if time.monotonic() > end:
                raise TimeoutError(f"waited {PATIENCE:.0f} s for {what}; {self.scene()}")
            self.ctx.yield_()
            time.sleep(0.03)

    def scene(self) -> str:
        """What may stand in the way."""
        state = self.state
        asked = {
            "opening": state.source.opening, "banner": state.window.banner, "leaving": state.editing.leaving,
            "tuning": state.tuning.shown, "grid": state.tuning.grid is not None,
            "help": state.window.help_open,
            "picture wanted": state.picture_request is not None,
            "popup": imgui.is_popup_open("", imgui.PopupFlags_.any_popup),
        }  # fmt: skip
        return ", ".join(f"{name}: {value}" for name, value in asked.items())

    # ---- where every deed begins and ends

    def settled(self) -> bool:
        state = self.state
        return state.picture.pictures is not None and not state.pictures_wait and state.source.opening is None

    def open(self, path: Path) -> None:
        actions.open_path(self.state, path)
        if self.state.editing.leaving is not None:
            edit_actions.answer(self.state, "discard")
        if self.state.session.leaving is not None:
            session_actions.answer(self.state, "discard")
        self.wait(lambda: self.state.source.opening is None, f"{path.name} to open")
        if self.state.source.clip is not None:
            self.wait(self.settled, f"the pictures of {path.name}")
        self.pace()

    def rest(self) -> None:
        """The clip alone, in its first state, with nothing under way: what memory is measured at."""
        state = self.state
        if state.runs.reconstruction.is_alive:
            job_actions.cancel(state)
            self.wait(lambda: not state.runs.reconstruction.is_alive, "the cancelled job")
        state.window.banner, state.window.help_open, state.exports.shown = None, False, False
        if state.tuning.shown:
            tuning_actions.toggle_tuning(state)
        self.open(self.clip)
        self.ctx.key_press(K._0)
        tidy(self.places)
        self.wait(lambda: not state.is_busy, "rest")
        end = time.monotonic() + RESTING
        self.wait(lambda: time.monotonic() > end, "what is done at rest")


def tidy(places: Places) -> None:
    """What was exported and reconstructed, but for the newest: the disk is not what is tried here."""
    for folder, keep in ((places.pictures, KEEP_FILES), (places.runs, 4)):
        found = sorted(folder.glob("*"), key=lambda path: path.stat().st_mtime)
        for path in found[:-keep]:
            shutil.rmtree(path) if path.is_dir() else path.unlink()


def quieten(ctx: Context) -> None:
    """The engine keeps no log, which would grow, and no watch, which would end a long test."""
    io = ctx.engine_io
    io.config_verbose_level = io.config_verbose_level_on_error = imgui.test_engine.TestVerboseLevel.error
    io.config_watchdog_warning = io.config_watchdog_kill_test = io.config_watchdog_kill_app = FOREVER
