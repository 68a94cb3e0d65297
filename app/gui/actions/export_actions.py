"""What a person can export, as functions on the state."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.state.comparison import ENHANCED, ORIGINAL, SIDES, Side, label_of
from app.gui.state.panes import other_request, why_not
from app.gui.work.background import Failure
from app.gui.work.enhancing import PictureRequest
from app.gui.work.shots import Exporting, ExportRequest, Form, Shot, Step
from app.moments import FRAMES_PER_SECOND

What = Literal[
    "left pane",
    "right pane",
    "both panes",
    "video of both panes",
    "measures of both panes",
    "video of the 3D view",
]


@dataclass(frozen=True)
class Offer:
    """One kind of export, in words."""

    form: Form
    sides: tuple[Side, ...]
    text: str


OFFERS: dict[What, Offer] = {
    "left pane": Offer("panes", ("left",), "A PNG of what the left pane shows."),
    "right pane": Offer("panes", ("right",), "A PNG of what the right pane shows."),
    "both panes": Offer("panes", SIDES, "A PNG with both panes side by side, labelled."),
    "video of both panes": Offer(
        "panes video", SIDES, "Every frame of the clip, both panes side by side, labelled."
    ),
    "measures of both panes": Offer(
        "measures", SIDES, "DV/BV, contrast, noise and more at every frame: CSV and JSON."
    ),
    "video of the 3D view": Offer("view video", (), "The 3D view from here through the time of the clip."),
}


def toggle_export(state: AppState) -> None:
    state.export_open = not state.export_open


def why_not_export(state: AppState, what: What) -> str:
    """What it still lacks, in a sentence; empty when it can start."""
    if state.exporting is not None:
        return "Another export is under way."
    if OFFERS[what].form == "view video":
        if state.plain_view_request is None or state.model is None:
            return "There is no 3D view yet."
        return "Wait for the reconstruction to end: its model changes." if state.model.live else ""
    if state.clip is None or state.picture_request is None:
        return "Open a clip first."
    reasons = (why_not(state, state.comparison.source(side)) for side in OFFERS[what].sides)
    return next((reason for reason in reasons if reason), "")


def export_request(state: AppState, what: What, scale: int) -> ExportRequest | None:
    """The export as things stand now; None where `why_not_export` says why."""
    if why_not_export(state, what):
        return None
    offer, view = OFFERS[what], None
    rate = (state.clip.frames_per_second if state.clip else None) or FRAMES_PER_SECOND
    if offer.form == "view video":
        assert state.plain_view_request is not None
        view = replace(state.plain_view_request.of_kind("color"), reduced=False).scaled(scale)
        stem = view.shown.name
    else:
        assert state.clip is not None
        stem = state.clip.path.stem
    shots = tuple(_shot(state, side) for side in offer.sides)
    request = ExportRequest(
        state.places.pictures, stem, offer.form, shots, view, scale, rate, state.opened_options
    )
    state.exporting = Exporting(request)
    return request


def _shot(state: AppState, side: Side) -> Shot:
    """What a side shows; in white light the photo, whatever is chosen."""
    source, picture = state.comparison.source(side), state.picture_request
    assert picture is not None
    if source == ORIGINAL or not state.enhancing:
        return Shot("Original", _photo(picture))
    if source == ENHANCED:
        return Shot("Enhanced", _photo(picture), picture.params)
    request = other_request(state, side)
    assert request is not None
    return Shot(label_of(source), request.photo, request.by)


def _photo(picture: PictureRequest) -> PictureRequest:
    return replace(picture, params=None)


def take_step(state: AppState, request: ExportRequest, answer: Step | Failure) -> None:
    """It has come further, has ended, or has failed."""
    if state.exporting is None or state.exporting.request is not request:
        return
    if isinstance(answer, Failure):
        state.exporting = None
        actions.fail(state, f"the export was not written: {answer.message}")
    elif answer.path is not None:
        state.exporting = None
        actions.announce(state, f"exported {answer.path.name} in {answer.path.parent.name}/")
    else:
        state.exporting.done = answer.done


def cancelled(state: AppState) -> None:
    """Nothing has been written."""
    state.exporting = None
    actions.announce(state, "export cancelled")
