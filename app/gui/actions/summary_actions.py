"""What a user can do with the case summary, as functions on the state."""

from __future__ import annotations

from dataclasses import replace
from datetime import date
from pathlib import Path

from app.enhancement.settable import LONGEST_NAME, LONGEST_NOTES
from app.exports.exporting import UNTITLED, ExportRequest, Step, Summary
from app.exports.records import MEASURES, PanesPicture
from app.exports.sources import Opened
from app.gui.actions import actions, export_actions
from app.gui.actions.export_names import why_not_name
from app.gui.session_file import MOST_ITEMS, SummaryDraft
from app.gui.state.app_state import AppState
from app.gui.state.choosing import SAVED
from app.gui.state.summary import Item
from app.gui.work.background import Failure
from renderer.clip import ByteImage

STEM = "case-summary"


def why_not_add(state: AppState) -> str:
    """What is lacking, in a sentence; empty when what is shown can be added."""
    if len(state.summary.items) + len(state.summary.awaited) >= MOST_ITEMS:
        return f"There are {MOST_ITEMS} images already."
    if state.source.clip is None and state.plain_view_request is None:
        return "Open a clip, an image or a run first."
    return export_actions.why_not_save(state)


def add_shown(state: AppState) -> None:
    """What is shown now, saved as a picture with its measures beside whatever is exported."""
    if reason := why_not_add(state):
        actions.fail(state, f"the image was not added: {reason}")
        return
    request = export_actions.shown_request(state)
    if request is None:
        return
    if isinstance(request.record, PanesPicture) and request.record.panes:
        measured = replace(request.record, measures=MEASURES, noise_cut="unclipped", lengths="by size")
        request = replace(request, record=measured)
    state.summary.awaited += (request,)
    export_actions.ask_image(state, request)


def take_saved(state: AppState, request: ExportRequest, answer: Step | Failure) -> None:
    """A picture of what is shown has been written, or has not; some are for the page."""
    export_actions.take_saved(state, request, answer)
    if request in state.summary.awaited and (isinstance(answer, Failure) or answer.path is not None):
        state.summary.awaited = tuple(one for one in state.summary.awaited if one is not request)
        if not isinstance(answer, Failure) and answer.path is not None:
            add_file(state, answer.path)


def add_file(state: AppState, path: Path) -> None:
    """A picture that was saved before, once."""
    path = path.absolute()
    if len(state.summary.items) >= MOST_ITEMS:
        actions.fail(state, f"{path.name} was not added: there are {MOST_ITEMS} images already")
    elif any(item.path == path for item in state.summary.items):
        actions.announce(state, f"{path.name} is in the case summary already")
    elif path.suffix.lower() not in SAVED.suffixes:
        actions.fail(state, f"expected a PNG or JPEG image that VesselSplat saved, got {path.name}")
    else:
        state.summary.items += (Item(path),)
        actions.announce(state, f"{path.name} is in the case summary")


def remove(state: AppState, place: int) -> None:
    """From the page; its file stays."""
    items = state.summary.items
    state.summary.items = items[:place] + items[place + 1 :]


def move(state: AppState, place: int, by: int) -> None:
    """Up or down; past an end it stays."""
    items, target = list(state.summary.items), place + by
    if 0 <= target < len(items):
        items[place], items[target] = items[target], items[place]
        state.summary.items = tuple(items)


def type_title(state: AppState, title: str) -> None:
    state.summary.title = title[:LONGEST_NAME]


def type_notes(state: AppState, notes: str) -> None:
    """On all of it."""
    state.summary.notes = notes[:LONGEST_NOTES]


def why_not_add_notes(state: AppState) -> str:
    """In a sentence; empty where the case has notes that the page lacks."""
    if not state.session.notes.strip():
        return "The case has no notes yet: View > Notes."
    return "They are on the page." if state.session.notes in state.summary.notes else ""


def add_notes(state: AppState) -> None:
    """Those of the case, below what the page has."""
    if not why_not_add_notes(state):
        type_notes(state, "\n".join(filter(None, (state.summary.notes, state.session.notes))))


def type_note(state: AppState, place: int, note: str) -> None:
    """Change the note below the picture at `place`."""
    items = list(state.summary.items)
    items[place] = replace(items[place], note=note[:LONGEST_NOTES])
    state.summary.items = tuple(items)


def why_not_write(state: AppState) -> str:
    """What the page still lacks, in a sentence; empty when it can be written."""
    if state.exports.under_way is not None:
        return "Another export is running."
    if state.summary.awaited:
        return "An image is still being saved."
    return "" if state.summary.items else "Add an image first."


def write_page(state: AppState) -> None:
    """Into the folder of exports, as an export like others."""
    if why_not_write(state):
        return
    chosen = state.summary
    title = chosen.title.strip() or UNTITLED
    pictures = tuple((item.path, item.note) for item in chosen.items)
    wanted = Summary(title, date.today().isoformat(), chosen.notes, pictures)
    stem = title if not why_not_name(title) and chosen.title.strip() else STEM
    opened = Opened(files=wanted.files)
    export_actions.begin(state, ExportRequest(state.export_folder, stem, ".html", wanted, opened))


def restore(state: AppState, draft: SummaryDraft, places: tuple[Path | None, ...]) -> None:
    """As a session has kept it; `places` are those of its pictures, None where one is no longer there."""
    kept = zip(draft.pictures, places, strict=True)
    state.summary.items = tuple(Item(place, one.note) for one, place in kept if place is not None)
    state.summary.title, state.summary.notes = draft.title, draft.notes
    state.summary.awaited = ()  # What is being saved was for the case before.
    if lost := places.count(None):
        actions.say(state, f"{lost} of {len(places)} images of the case summary are no longer there")


def thumbnail_wish(state: AppState) -> Path | None:
    """The first picture in the panel that has none yet."""
    if not state.summary.shown:
        return None
    known = state.summary.thumbnails
    return next((item.path for item in state.summary.items if item.path not in known), None)


def take_thumbnail(state: AppState, request: Path, answer: ByteImage | Failure | None) -> None:
    state.summary.thumbnails[request] = None if isinstance(answer, Failure) else answer
