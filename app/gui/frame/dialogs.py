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
from app.gui.style.widgets import em, within

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


@dataclass
class Browser:
    """The dialog inside the window: where it is, and what has been typed or marked."""

    kind: Kind
    folder: Path
    entries: list[Entry]
    path: Path
    text: str

    @classmethod
    def at(cls, folder: Path, kind: Kind) -> Browser:
        return cls(kind, folder, listing(folder, kind), folder, legible(str(folder)))

    def mark(self, path: Path) -> None:
        self.path, self.text = path, legible(str(path))


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
        if not has_desktop_dialogs():
            self.browser = Browser.at(self._start, kind)
        elif kind == "folder":
            self._desktop = desktop.select_folder(TITLES[kind], legible(str(self._start)))
        else:
            self._desktop = desktop.open_file(TITLES[kind], legible(str(self._start)))

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
        if imgui.button(f"{icons.ICON_FA_ARROW_UP}##up"):
            self._enter(browser.folder.parent)
        imgui.same_line()
        imgui.set_next_item_width(-1)
        if imgui.is_window_appearing():
            imgui.set_keyboard_focus_here()
        changed, text = imgui.input_text("##path", browser.text)
        if changed:
            self.type(text)

    def type(self, text: str) -> None:
        """What stands in the line now; a folder's whole name goes there."""
        if self.browser is None:
            return
        path = self.browser.folder / typed(text)
        self.browser.path, self.browser.text = path, text
        if path != self.browser.folder and kind_of(path) == "folder":
            self._enter(path)

    def _enter(self, folder: Path) -> None:
        if self.browser is not None:
            self.browser = Browser.at(folder, self.browser.kind)

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
            if imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
                self._take(entry)

    def _take(self, entry: Entry) -> None:
        if entry.kind == "file":
            self._choose(entry.path)
        elif entry.kind == "folder":
            self._enter(entry.path)

    def _draw_choice(self, browser: Browser) -> None:
        path, fits = browser.path, kind_of(browser.path) == browser.kind
        # Not the Enter that asked for the dialog.
        entered = not imgui.is_window_appearing() and any(imgui.is_key_pressed(key, False) for key in ENTER)
        imgui.begin_disabled(not fits)
        with imgui_ctx.push_style_color(imgui.Col_.button, theme.now().lit):
            if imgui.button("Open", ImVec2(em(8), 0)) or (fits and entered):
                self._choose(path)
                # Else what lies below has a control in focus, which the next Space presses.
                imgui.set_nav_cursor_visible(False)
        imgui.end_disabled()
        imgui.same_line()
        if imgui.button("Cancel", ImVec2(em(8), 0)) or imgui.is_key_pressed(imgui.Key.escape):
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
