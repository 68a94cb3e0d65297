"""Choosing a folder or a file: the desktop's own dialog, or where there is none a plain one."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from imgui_bundle import ImVec2, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons
from imgui_bundle import portable_file_dialogs as desktop

from app.files.legible import legible
from app.gui.state.window import Kind
from app.gui.style import theme
from app.gui.style.widgets import button, em, within

TITLES: dict[Kind, str] = {"folder": "Open a folder", "file": "Open a file"}
EMPTY: dict[Kind, str] = {
    "folder": "No folder inside: Open takes this one with the files in it.",
    "file": "No file or folder here.",
}
ENTER = (imgui.Key.enter, imgui.Key.keypad_enter)
OpenDialog = desktop.select_folder | desktop.open_file


def has_desktop_dialogs() -> bool:
    """On Linux they are programs of their own that may be missing, which looks like a cancelled dialog."""
    return not sys.platform.startswith("linux") or any(map(shutil.which, ("zenity", "kdialog")))


@dataclass(frozen=True)
class Entry:
    """A line of the dialog inside the window."""

    path: Path
    kind: Kind | None

    @property
    def name(self) -> str:
        return legible(self.path.name)


class Browser:
    """The dialog inside the window: where it is, and what has been typed or marked."""

    def __init__(self, folder: Path, kind: Kind) -> None:
        self.kind = kind
        self.enter(folder)

    def enter(self, folder: Path) -> None:
        self.folder, self.entries = folder, listing(folder, self.kind)
        self.mark(folder)

    def mark(self, path: Path) -> None:
        self.path, self.text = path, legible(str(path))

    def type(self, text: str) -> None:
        """What stands in the line now; a folder's whole name goes there."""
        self.path, self.text = self.folder / typed(text), text
        if self.path != self.folder and kind_of(self.path) == "folder":
            self.enter(self.path)


class Dialogs:
    """At most one dialog at a time."""

    def __init__(self, start: Path) -> None:
        self._start = start
        self._then: Callable[[Path], object] = lambda path: None
        self._desktop: OpenDialog | None = None
        self.browser: Browser | None = None

    def ask(self, kind: Kind, then: Callable[[Path], object]) -> None:
        """`then` is called with what the user picked."""
        if self._desktop is not None or self.browser is not None:
            return
        self._then = then
        if has_desktop_dialogs():
            dialog = desktop.select_folder if kind == "folder" else desktop.open_file
            self._desktop = dialog(TITLES[kind], legible(str(self._start)))
        else:
            self.browser = Browser(self._start, kind)

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
        self._then(path)

    def _draw_browser(self, browser: Browser) -> None:
        title = TITLES[browser.kind]
        imgui.open_popup(title)
        center = imgui.get_main_viewport().get_center()
        imgui.set_next_window_pos(center, imgui.Cond_.appearing, ImVec2(0.5, 0.5))
        imgui.set_next_window_size(within(40, 28), imgui.Cond_.appearing)
        with imgui_ctx.begin_popup_modal(title) as opened:
            if not opened:
                return
            self._draw_path(browser)
            with imgui_ctx.begin_child("entries", ImVec2(0, -em(2.4)), imgui.ChildFlags_.borders):
                self._draw_entries(browser)
            self._draw_choice(browser)

    def _draw_path(self, browser: Browser) -> None:
        button(f"{icons.ICON_FA_ARROW_UP}##up", lambda: browser.enter(browser.folder.parent))
        imgui.same_line()
        imgui.set_next_item_width(-1)
        if imgui.is_window_appearing():
            imgui.set_keyboard_focus_here()
        changed, text = imgui.input_text("##path", browser.text)
        if changed:
            browser.type(text)

    def _draw_entries(self, browser: Browser) -> None:
        if not browser.entries:
            imgui.text_colored(theme.now().muted, EMPTY[browser.kind])
        for index, entry in enumerate(browser.entries):
            icon = icons.ICON_FA_FOLDER if entry.kind == "folder" else icons.ICON_FA_FILE
            flags = imgui.SelectableFlags_.no_auto_close_popups | imgui.SelectableFlags_.allow_double_click
            label = f"{icon}  {entry.name}##{index}"
            marked, _ = imgui.selectable(label, browser.path == entry.path, flags)
            if not marked:
                continue
            browser.mark(entry.path)
            if imgui.is_mouse_double_clicked(imgui.MouseButton_.left) and entry.kind is not None:
                take = self._choose if entry.kind == "file" else browser.enter
                take(entry.path)

    def _draw_choice(self, browser: Browser) -> None:
        path, fits = browser.path, kind_of(browser.path) == browser.kind
        # Not the Enter that asked for the dialog.
        entered = not imgui.is_window_appearing() and any(imgui.is_key_pressed(key, False) for key in ENTER)
        if button("Open", enabled=fits, color=theme.now().lit, width=8) or (fits and entered):
            self._choose(path)
            # Else what lies below has a control in focus, which the next Space presses.
            imgui.set_nav_cursor_visible(False)
        imgui.same_line()
        if button("Cancel", width=8) or imgui.is_key_pressed(imgui.Key.escape):
            self.browser = None
            imgui.close_current_popup()


def typed(text: str) -> Path:
    """The path that was typed; `~` stands for a home folder where there is such a one."""
    try:
        return Path(text).expanduser()
    except RuntimeError:
        return Path(text)


def kind_of(path: Path) -> Kind | None:
    """What is there; None for nothing, and for what the system does not let us look at."""
    try:
        if path.is_dir():
            return "folder"
        return "file" if path.is_file() else None
    except OSError:
        return None


def listing(folder: Path, kind: Kind) -> list[Entry]:
    """What can be entered or chosen, folders first; hidden entries and, for folders, files are left out."""
    try:
        paths = [path for path in folder.iterdir() if not path.name.startswith(".")]
    except OSError:
        return []
    entries = [Entry(path, kind_of(path)) for path in paths]
    kept = [entry for entry in entries if entry.kind == "folder" or kind == "file"]
    return sorted(kept, key=lambda entry: (entry.kind != "folder", entry.name.lower()))
