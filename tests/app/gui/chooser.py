"""The file dialog of a window, driven by keys and mouse."""

from __future__ import annotations

from pathlib import Path

from imgui_bundle import imgui

from app.gui.actions import actions
from app.gui.frame.dialogs import Dialogs
from app.gui.panels.file_browser import draw_browser
from app.gui.state.app_state import AppState
from app.gui.state.browsing import Browsing
from app.gui.state.choosing import Kind, Purpose
from app.gui.update.channels import Channels
from tests.app.gui.ui import Shown, Ui


class Chooser:
    """The dialog of a window, with its background work done between frames."""

    def __init__(self, ui: Ui, state: AppState) -> None:
        self.ui, self.state = ui, state
        self.channels, self.dialogs = Channels(), Dialogs()
        self.chosen: list[Path] = []
        self.shown = Shown()

    def ask(self, kind: Kind, purpose: Purpose, folder: Path, name: str = "") -> None:
        self.state.window.folders = {purpose: folder}
        actions.choose_path(self.state, kind, lambda state, path: self.chosen.append(path), purpose, name)
        self.frames(4)

    @property
    def browsing(self) -> Browsing:
        assert self.state.window.browsing is not None
        return self.state.window.browsing

    def draw(self) -> None:
        imgui.button("below")
        self.dialogs.follow(self.state)
        draw_browser(self.state, self.shown)

    def frames(self, count: int = 3) -> None:
        for _ in range(count):
            for row in self.channels.rows:
                if row.channel in (self.channels.listing, self.channels.small_files):
                    row.ask(self.state)
                    row.channel.run_waiting()
                    row.answer(self.state)
            self.ui.frame(self.draw)

    def press(self, *keys: imgui.Key) -> None:
        for down in (True, False):
            for key in keys:
                self.ui.io.add_key_event(key, down)
            self.frames(1)
        self.frames(3)

    def type(self, text: str) -> None:
        self.ui.io.add_input_characters_utf8(text)
        self.frames(2)

    def names(self) -> list[str]:
        return [entry.name for entry in self.browsing.entries]
