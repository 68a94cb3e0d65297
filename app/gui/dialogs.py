"""Choosing a folder or a file: the desktop's own dialog, or where there is none a plain one."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from imgui_bundle import ImVec2, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons
from imgui_bundle import portable_file_dialogs as desktop

from app.gui import theme
from app.gui.widgets import em

Kind = Literal["folder", "file"]
TITLES: dict[Kind, str] = {"folder": "Open folder", "file": "Open image or video"}
OpenDialog = desktop.select_folder | desktop.open_file


def has_desktop_dialogs() -> bool:
    """On Linux they are programs of their own that may be missing, which looks like a cancelled dialog."""
    return not sys.platform.startswith("linux") or any(map(shutil.which, ("zenity", "kdialog")))


@dataclass
class Browser:
    """The dialog inside the window: where it is, and what has been typed."""

    kind: Kind
    folder: Path
    text: str
    entries: list[Path]


class Dialogs:
    """At most one dialog at a time; `chosen` is called with what the user picked."""

    def __init__(self, chosen: Callable[[Path], None], start: Path) -> None:
        self._chosen = chosen
        self._start = start
        self._desktop: OpenDialog | None = None
        self.browser: Browser | None = None

    def ask(self, kind: Kind) -> None:
        if self._desktop is not None or self.browser is not None:
            return
        if not has_desktop_dialogs():
            self.browser = Browser(kind, self._start, str(self._start), listing(self._start, kind))
        elif kind == "folder":
            self._desktop = desktop.select_folder(TITLES[kind], str(self._start))
        else:
            self._desktop = desktop.open_file(TITLES[kind], str(self._start))

    def draw(self) -> None:
        """Once a frame: take the desktop dialog's answer, or draw our own."""
        if self._desktop is not None and self._desktop.ready(0):
            result = self._desktop.result()
            paths = [result] if isinstance(result, str) else result
            self._desktop = None
            if paths and paths[0]:
                self._choose(Path(paths[0]))
        if self.browser is not None:
            self._draw_browser(self.browser)

    def _choose(self, path: Path) -> None:
        self._start = path.parent
        self.browser = None
        self._chosen(path)

    def _draw_browser(self, browser: Browser) -> None:
        title = TITLES[browser.kind]
        imgui.open_popup(title)
        center = imgui.get_main_viewport().get_center()
        imgui.set_next_window_pos(center, imgui.Cond_.appearing, ImVec2(0.5, 0.5))
        imgui.set_next_window_size(ImVec2(em(40), em(28)), imgui.Cond_.appearing)
        with imgui_ctx.begin_popup_modal(title) as opened:
            if not opened:
                return
            self._draw_path(browser)
            with imgui_ctx.begin_child("entries", ImVec2(0, -em(2.4)), imgui.ChildFlags_.borders):
                self._draw_entries(browser)
            self._draw_choice(browser)

    def _draw_path(self, browser: Browser) -> None:
        if imgui.button(f"{icons.ICON_FA_ARROW_UP}##up"):
            self._enter(browser.folder.parent)
        imgui.same_line()
        imgui.set_next_item_width(-1)
        if imgui.is_window_appearing():
            imgui.set_keyboard_focus_here()
        changed, browser.text = imgui.input_text("##path", browser.text)
        if changed and Path(browser.text).expanduser().is_dir():
            self._enter(Path(browser.text).expanduser())

    def _enter(self, folder: Path) -> None:
        if self.browser is not None:
            entries = listing(folder, self.browser.kind)
            self.browser = Browser(self.browser.kind, folder, str(folder), entries)

    def _draw_entries(self, browser: Browser) -> None:
        for entry in browser.entries:
            icon = icons.ICON_FA_FOLDER if entry.is_dir() else icons.ICON_FA_FILE
            flags = imgui.SelectableFlags_.no_auto_close_popups | imgui.SelectableFlags_.allow_double_click
            marked, _ = imgui.selectable(f"{icon}  {entry.name}", browser.text == str(entry), flags)
            if not marked:
                continue
            browser.text = str(entry)
            if imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
                (self._choose if entry.is_file() else self._enter)(entry)

    def _draw_choice(self, browser: Browser) -> None:
        path = Path(browser.text).expanduser()
        fits = path.is_dir() if browser.kind == "folder" else path.is_file()
        imgui.begin_disabled(not fits)
        with imgui_ctx.push_style_color(imgui.Col_.button, theme.ACCENT_DIM):
            if imgui.button("Open", ImVec2(em(8), 0)):
                self._choose(path)
        imgui.end_disabled()
        imgui.same_line()
        if imgui.button("Close", ImVec2(em(8), 0)) or imgui.is_key_pressed(imgui.Key.escape):
            self.browser = None
            imgui.close_current_popup()


def listing(folder: Path, kind: Kind) -> list[Path]:
    """What can be entered or chosen, folders first; hidden entries and, for folders, files are left out."""
    try:
        entries = [entry for entry in folder.iterdir() if not entry.name.startswith(".")]
    except OSError:
        return []
    kept = [entry for entry in entries if entry.is_dir() or kind == "file"]
    return sorted(kept, key=lambda entry: (not entry.is_dir(), entry.name.lower()))
