"""What a user can do in the file dialog inside the window, as functions on the state."""

from __future__ import annotations

import os
from datetime import datetime
from pathlib import Path

from app.files.legible import legible, to_minute
from app.gui.actions import actions
from app.gui.actions.export_names import why_not_name
from app.gui.state.app_state import AppState
from app.gui.state.browsing import MOST_THUMBNAILS, Browsing, Column
from app.gui.state.choosing import Choosing
from app.gui.work.background import Failure
from app.gui.work.listing import Entry, Listing, ListRequest, entry_at, is_folder
from renderer.clip import ByteImage

READING = "Reading the folder…"


def begin(state: AppState, choosing: Choosing) -> None:
    """Open a file dialog, unless one is open."""
    if state.window.browsing is None:
        state.window.browsing = Browsing(choosing, choosing.start, name=choosing.name)
        enter(state.window.browsing, choosing.start)


def enter(browsing: Browsing, folder: Path) -> None:
    """Look into a folder; nothing in it is marked."""
    _look_into(browsing, folder, browsing.folder if folder == browsing.folder.parent else None)
    browsing.mark(None)


def _look_into(browsing: Browsing, folder: Path, came_from: Path | None = None) -> None:
    browsing.folder, browsing.listing, browsing.came_from, browsing.in_sight = folder, None, came_from, ()


def go_up(browsing: Browsing) -> None:
    """To the folder that holds this one."""
    if browsing.folder.parent != browsing.folder:
        enter(browsing, browsing.folder.parent)


def type_path(browsing: Browsing, text: str) -> None:
    """What stands in the line now; the folder of a path that ends as that of one is listed."""
    browsing.text, browsing.typed, browsing.marked = text, True, None
    # What is typed from the folder on would mean something else in another one.
    is_whole = Path(text).is_absolute() or text.startswith("~")
    path = typed_path(browsing)
    if is_whole and text.endswith(("/", os.sep)) and path != browsing.folder and is_folder(path):
        _look_into(browsing, path)


def type_name(browsing: Browsing, name: str) -> None:
    """Of the file to be written; it goes before the name of one in the line of the path."""
    browsing.name = name
    if browsing.typed and not is_folder(typed_path(browsing)):
        browsing.text, browsing.typed = legible(str(browsing.folder)), False


def move(browsing: Browsing, by: int) -> None:
    """Mark another entry, so many further down."""
    paths = [entry.path for entry in browsing.entries]
    if not paths:
        return
    now = paths.index(browsing.marked) if browsing.marked in paths else (-1 if by > 0 else len(paths))
    mark(browsing, browsing.entries[min(max(now + by, 0), len(paths) - 1)])


def mark(browsing: Browsing, entry: Entry) -> None:
    """Mark an entry of the list."""
    browsing.mark(entry.path)
    if browsing.choosing.kind == "save" and entry.kind == "file":
        browsing.name = entry.name


def sort(browsing: Browsing, column: Column, *, descending: bool) -> None:
    """What the list is ordered by."""
    browsing.column, browsing.descending = column, descending


def choose_filter(browsing: Browsing, place: int) -> None:
    """Which files are listed."""
    browsing.filter = place


def typed_path(browsing: Browsing) -> Path:
    """What stands in the line, from the folder on, or the only one listed of which it is the beginning;
    `~` stands for a home folder where there is such a one."""
    if not browsing.typed:
        return browsing.marked or browsing.folder
    try:
        path = browsing.folder / Path(browsing.text).expanduser()
    except RuntimeError:
        path = browsing.folder / browsing.text
    only = browsing.entries[0] if browsing.begun and len(browsing.entries) == 1 else None
    is_beginning = only is not None and only.name.casefold().startswith(browsing.begun)
    return only.path if only is not None and is_beginning and _listed(browsing, path) is None else path


def _listed(browsing: Browsing, path: Path) -> Entry | None:
    found = browsing.listing.entries if browsing.listing is not None else ()
    return next((entry for entry in found if entry.path == path), None)


def _kind_at(browsing: Browsing, path: Path) -> str | None:
    """Of what lies there, as listed, else looked up once: every frame asks, and the disk may be far away."""
    if path == browsing.folder:
        return "folder"
    key = (path, browsing.listing)
    if browsing.looked is None or browsing.looked[0] != key:
        browsing.looked = key, _listed(browsing, path) or entry_at(path)
    return browsing.looked[1].kind


def opens(state: AppState, browsing: Browsing) -> None:
    """Enter, or a double click: goes into the folder, or chooses the file."""
    path = typed_path(browsing)
    if path != browsing.folder and _kind_at(browsing, path) == "folder":
        enter(browsing, path)
    elif not why_not(browsing) and not (browsing.choosing.kind == "save" and replaces(browsing)):
        choose(state, browsing)


def why_not(browsing: Browsing) -> str:
    """What keeps `choose` from going on, in a sentence; empty for nothing."""
    if browsing.choosing.kind == "save":
        return _why_not_saved(browsing)
    kind = _kind_at(browsing, typed_path(browsing))
    if kind is None and browsing.listing is None:
        return READING  # It may be the beginning of a name there.
    if browsing.choosing.kind == "folder":
        taken = kind == "folder" or (browsing.choosing.question.takes_files and kind == "file")
        return "" if taken else "Choose a folder." if kind == "file" else "There is no such folder."
    if kind == "file":
        return ""
    return "Choose a file." if kind == "folder" else "There is no such file."


def _why_not_saved(browsing: Browsing) -> str:
    if browsing.listing is None:
        return READING  # What it holds is not to be replaced unseen.
    folder, name = _wanted(browsing)
    if browsing.typed and not is_folder(folder):
        return "There is no such folder."
    return why_not_name(name) if name else "Type a name first."


def _wanted(browsing: Browsing) -> tuple[Path, str]:
    """Folder and name of the file to be written: as typed into the line, else as shown."""
    if not browsing.typed:
        return browsing.folder, browsing.name.strip()
    path = typed_path(browsing)
    return (path, browsing.name.strip()) if is_folder(path) else (path.parent, path.name)


def target(browsing: Browsing) -> Path:
    """The file to be written."""
    (folder, name), suffix = _wanted(browsing), browsing.choosing.question.filters[0].suffixes[0]
    return folder / (name if name.lower().endswith(suffix) else f"{name}{suffix}")


def replaces(browsing: Browsing) -> bool:
    """Whether a file of that name exists and would be replaced."""
    return os.path.lexists(target(browsing))


def choose(state: AppState, browsing: Browsing) -> None:
    """Go on with what is marked or typed; the dialog closes."""
    if not why_not(browsing):
        state.window.browsing = None
        path = target(browsing) if browsing.choosing.kind == "save" else typed_path(browsing)
        chosen(state, browsing.choosing, path)


def chosen(state: AppState, choosing: Choosing, path: Path) -> None:
    """A person has chosen it, in this dialog or the desktop's: where that was is remembered."""
    folder = path if choosing.question.keeps_itself else path.parent
    actions.visit(state, folder, choosing.purpose)
    choosing.then(path)


def cancel(state: AppState) -> None:
    state.window.browsing = None


def list_wish(state: AppState) -> ListRequest | None:
    browsing = state.window.browsing
    return browsing.request if browsing is not None else None


def take_listing(state: AppState, request: ListRequest, answer: Listing | Failure) -> None:
    """Of a folder that is no longer looked at, it is dropped."""
    browsing = state.window.browsing
    if browsing is None or browsing.request != request:
        return
    if isinstance(answer, Failure):
        answer = Listing(request.folder, trouble=answer.message)
    browsing.listing = answer
    if answer.folder != browsing.folder:
        browsing.folder = answer.folder
        browsing.mark(None)
    if browsing.came_from is not None:
        found = next((one for one in browsing.entries if one.path == browsing.came_from), None)
        browsing.came_from = None
        if found is not None and not browsing.typed:
            mark(browsing, found)


def thumbnail_wish(state: AppState) -> Path | None:
    """The first entry on screen that has none yet."""
    browsing = state.window.browsing
    if browsing is None:
        return None
    return next((path for path in browsing.in_sight if path not in browsing.thumbnails), None)


def take_thumbnail(state: AppState, request: Path, answer: ByteImage | Failure | None) -> None:
    browsing = state.window.browsing
    if browsing is not None:
        browsing.thumbnails[request] = None if isinstance(answer, Failure) else answer
        while len(browsing.thumbnails) > MOST_THUMBNAILS:
            browsing.thumbnails.popitem(last=False)


def see(browsing: Browsing, entries: list[Entry]) -> None:
    """Remember which entries are on screen."""
    browsing.in_sight = tuple(entry.path for entry in entries if entry.may_have_thumbnail)


def focused(browsing: Browsing) -> None:
    """The line is typed into."""
    browsing.focus = False


def scrolled(browsing: Browsing) -> None:
    """The marked entry is in sight."""
    browsing.scroll = False


def dated(entry: Entry) -> str:
    """When it was changed last; empty where what the system says is no time of the calendar."""
    try:
        return to_minute(datetime.fromtimestamp(entry.modified))
    except (ValueError, OverflowError, OSError):
        return ""
