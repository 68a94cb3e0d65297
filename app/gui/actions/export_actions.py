"""What a user can export, as functions on the state."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

from app.enhancement.frame_enhancer import PictureRequest
from app.enhancement.settable import ENHANCED
from app.exports.exporting import ExportRequest, Step
from app.exports.make import Views
from app.exports.panes import pane_record
from app.exports.records import (
    MEASURES,
    Arrangement,
    FrameRecord,
    MeasuresTable,
    PaneRecord,
    PanesPicture,
    PanesRecord,
    PanesVideo,
    ViewVideo,
)
from app.exports.sizing import Sizing
from app.exports.sources import Opened
from app.files.legible import located
from app.files.records import extended
from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.state.pace import Pace
from app.gui.state.panes import other_request, shown_mode, why_not
from app.gui.views.comparison import SIDES, Side, label_of
from app.gui.work.background import Failure
from app.scenes.cpu_rendering import ON_CPU
from app.scenes.scene import Scene
from app.scenes.view_request import FrameRequest, ViewRequest, drawn_record, moment_record, view_record
from app.scenes.view_selection import FRAMES_PER_SECOND

What = Literal[
    "panes and 3D view",
    "panes as shown",
    "left pane",
    "right pane",
    "both panes",
    "3D view",
    "video of the panes",
    "video of both panes",
    "video through time",
    "video along the path",
    "measures of both panes",
]

Form = Literal["picture", "panes video", "view video", "measures"]
MOST_DRAWN = 2**25
"""Pixels of the 3D view drawn at once: 3840 × 2160 at 2×, some 0.7 GB while they are averaged."""


@dataclass(frozen=True)
class Offer:
    """One kind of export, in words."""

    label: str
    form: Form
    text: str
    sides: tuple[Side, ...] = ()
    as_shown: bool = False
    """The panes as the mode of comparison sets them against each other."""
    sees: Literal["no", "still", "time", "path"] = "no"
    """What is made of the 3D view."""


OFFERS: dict[What, Offer] = {
    "panes and 3D view": Offer(
        "All as shown", "picture", "S: the panes as shown and the 3D view, on one page.",
        SIDES, True, "still",
    ),
    "panes as shown": Offer(
        "Panes as shown", "picture", "Side by side, wipe, one pane, or the difference.", SIDES, True
    ),
    "left pane": Offer("Left pane", "picture", "What the left side shows.", ("left",)),
    "right pane": Offer("Right pane", "picture", "What the right side shows.", ("right",)),
    "both panes": Offer("Both panes", "picture", "Side by side, whatever the mode.", SIDES),
    "3D view": Offer("3D view", "picture", "The 3D view as shown, with the second one.", sees="still"),
    "video of the panes": Offer(
        "Panes as shown", "panes video", "Every frame from In to Out, compared as on screen.", SIDES, True
    ),
    "video of both panes": Offer(
        "Both panes", "panes video", "Every frame from In to Out, side by side.", SIDES
    ),
    "video through time": Offer(
        "3D through time", "view video", "The 3D view as shown, and the second one, through the clip.",
        sees="time",
    ),
    "video along the path": Offer(
        "3D along the path", "view video", "The 3D view, and the second one, along the camera path.",
        sees="path",
    ),
    "measures of both panes": Offer(
        "Table of both panes", "measures", "DV/BV, contrast, noise and more, from In to Out: CSV, JSON.",
        SIDES,
    ),
}  # fmt: skip


def toggle_export(state: AppState) -> None:
    state.exports.shown = not state.exports.shown


def why_not_export(state: AppState, what: What) -> str:
    """What it still lacks, in a sentence; empty when it can start."""
    if state.exports.under_way is not None:
        return "Another export is running."
    return _lacks(state, OFFERS[what])


def _lacks(state: AppState, offer: Offer) -> str:
    needs_view = offer.sees != "no" and not (offer.sides and state.source.clip is not None)
    if needs_view and state.plain_view_request is None:
        return "There is no 3D view yet."
    if offer.sees != "no" and (reason := _too_large(state)):
        return reason
    if offer.form == "view video" and state.scene.model is not None and state.scene.model.live:
        return "The reconstruction is not finished: wait for it or continue it."
    if offer.sees == "path" and not state.scene.cameras.views.path.keyframes:
        return "There is no camera path yet: create one in the Cameras panel."
    seen = offer.sees == "time" and state.scene.viewer.snapped
    if offer.form == "view video" and state.scene.kind == "difference" and not seen:
        return "A difference is shown from the clip's camera only: press C or choose another view."
    if not offer.sides or (offer.sees == "still" and state.source.clip is None):
        return ""
    if state.source.clip is None:
        return "Open a clip first."
    if offer.form == "panes video" and not state.source.clip.has_one_size:
        return "The images differ in size: no video can show them."
    if offer.as_shown:
        return ""
    reasons = (why_not(state, state.comparing.chosen.source(side)) for side in offer.sides)
    return next((reason for reason in reasons if reason), "")


def _too_large(state: AppState) -> str:
    """What cannot be drawn at once, of the 3D view as large and as fine as chosen; empty when it can."""
    if state.plain_view_request is None:
        return ""
    factor = state.exports.supersampling
    camera = sized(state.plain_view_request, state.exports.view_size).camera
    drawn, size = camera.width * camera.height * factor**2, f"{camera.width} × {camera.height}"
    if drawn <= MOST_DRAWN:
        return ""
    return f"{size} at {factor}× needs {drawn / 1e6:.0f} million pixels; the limit is {MOST_DRAWN / 1e6:.0f}."


def export_request(state: AppState, what: What) -> ExportRequest | None:
    """The export as things stand now, which is then under way; None where `why_not_export` says why."""
    if why_not_export(state, what):
        return None
    request = _request(state, OFFERS[what])
    state.exports.under_way, state.exports.pace = request, Pace()
    return request


def save_picture(state: AppState) -> None:
    """A PNG of what is shown, written in the background beside whatever is exported."""
    offer = OFFERS["panes and 3D view"]
    if reason := _lacks(state, offer):
        actions.fail(state, f"the image was not saved: {reason}")
    else:
        state.window.wishes += (_request(state, offer),)


def shown_request(state: AppState) -> ExportRequest | None:
    """What there is to see of panes and 3D view; None where there is neither."""
    seen = state.source.clip is not None or state.plain_view_request is not None
    return _request(state, OFFERS["panes and 3D view"]) if seen else None


def _request(state: AppState, offer: Offer) -> ExportRequest:
    clip, moments = state.source.clip, _moments(state, offer)
    views = tuple(view for views in moments for view in views)
    panes = _panes(state, offer)
    stem = clip.path.stem if clip is not None and panes.panes else views[0].scene.name
    rate = FRAMES_PER_SECOND if clip is None or offer.sees == "path" else clip.frames_per_second
    record = _record(state, offer.form, panes, moments, rate or FRAMES_PER_SECOND)
    opened = Opened(views, clip, state.scene.model, measured=state.picture.of_clip)
    return ExportRequest(state.places.pictures, stem, record, opened)


def _record(
    state: AppState, form: Form, panes: PanesRecord, moments: tuple[Views, ...], rate: float
) -> PanesPicture | PanesVideo | MeasuresTable | ViewVideo:
    if form == "picture":
        seen = tuple(view_record(view, ON_CPU) for views in moments for view in views)
        return extended(PanesPicture, panes, views=seen)
    if form == "view video":
        return ViewVideo(
            views=tuple(drawn_record(view, ON_CPU) for view in moments[0]),
            moments=tuple(moment_record(views[0]) for views in moments),
            frames_per_second=rate,
        )
    first, last = state.source.span
    if form == "measures":
        return extended(MeasuresTable, panes, first_frame=first, last_frame=last, measures=MEASURES)
    return extended(PanesVideo, panes, first_frame=first, last_frame=last, frames_per_second=rate)


def _panes(state: AppState, offer: Offer) -> PanesRecord:
    """What the sides show, one of them where both show the same, and how they are laid out."""
    picture, sides = state.picture_request, offer.sides
    if picture is None or not sides:
        return PanesRecord()
    mode = shown_mode(state) if offer.as_shown else "side by side"
    if mode == "flip":
        sides, mode = ("left" if state.comparing.chosen.flipped else "right",), "side by side"
    return PanesRecord(
        clip_options=state.source.options,
        frame=FrameRecord(index=picture.frame_index, label=picture.clip.labels[picture.frame_index]),
        **vars(state.exports.sizing),
        arrangement=Arrangement(mode, state.comparing.wiped),
        panes=tuple(dict.fromkeys(_pane(state, side, picture) for side in sides)),
    )


def _pane(state: AppState, side: Side, picture: PictureRequest) -> PaneRecord:
    """What a side shows; in white light and while the original is peeked at the frame, whatever is chosen."""
    source, original = state.comparing.chosen.source(side), replace(picture, params=None)
    active = state.enhancement.active and not state.enhancement.peeking
    if active and source == ENHANCED:
        return pane_record("Enhanced", original, picture.params)
    request = other_request(state, side) if active else None
    # As on screen, the original also where there is nothing else to show.
    if request is None:
        return pane_record("Original", original)
    frames = request.by.record.trained_on if isinstance(request.by, Scene) else ""
    title = f"{label_of(source)}   from {frames}" if frames else label_of(source)
    return pane_record(title, request.original, request.by)


def _moments(state: AppState, offer: Offer) -> tuple[Views, ...]:
    """The 3D view once, or once a frame of its video; each time with the second one, where there is one."""
    view = state.plain_view_request
    if view is None or offer.sees == "no":
        return ()
    if offer.sees == "still":
        return (_with_second(state, view),)
    moving = _through_time(state, view.scene) if offer.sees == "time" else _along_path(state, view.scene)
    return tuple(_with_second(state, first) for first in moving)


def _with_second(state: AppState, first: ViewRequest) -> Views:
    both = (first, state.scene.beside(first))
    return tuple(_as_chosen(state, one) for one in both if one is not None)


def _as_chosen(state: AppState, view: ViewRequest) -> ViewRequest:
    """In the size and with the averaging that are chosen."""
    return replace(sized(view, state.exports.view_size), supersampling=state.exports.supersampling)


def _through_time(state: AppState, scene: Scene) -> Iterator[ViewRequest]:
    """Every frame of the clip, from here or through its own cameras, where a difference is to its frame."""
    clip = state.source.clip if state.has_frames else None
    for frame in range(len(scene.cameras)):
        if state.scene.viewer.snapped:
            reference = FrameRequest(clip, scene.start + frame) if clip is not None else None
            yield ViewRequest.of_frame(scene, frame).of_kind(state.scene.kind, reference)
        else:
            view = ViewRequest.fitted(scene, scene.time(frame), state.scene.viewer.free, state.scene.size)
            yield view.of_kind(state.scene.kind)


def _along_path(state: AppState, scene: Scene) -> Iterator[ViewRequest]:
    """As `vesselsplat export --path` goes along it."""
    for key in state.scene.cameras.views.path.moments(FRAMES_PER_SECOND):
        yield ViewRequest(scene, key.time, key.camera.fitted(*state.scene.size)).of_kind(state.scene.kind)


def sized(view: ViewRequest, size: tuple[int, int] | None) -> ViewRequest:
    """With so many pixels; without a size in its own shape, no smaller than the clip's frames.

    A difference keeps the frame's shape, within the size.
    """
    camera, clip_camera = view.camera, view.scene.cameras[0]
    if size is None:
        scale = max(1.0, clip_camera.width / camera.width, clip_camera.height / camera.height)
    elif view.kind == "difference":
        scale = min(size[0] / camera.width, size[1] / camera.height)
    else:
        return replace(view, camera=camera.fitted(*size))
    width, height = max(1, round(scale * camera.width)), max(1, round(scale * camera.height))
    return replace(view, camera=camera.resized(width, height))


def take_step(state: AppState, request: ExportRequest, answer: Step | Failure) -> None:
    """It has come further, has ended, or has failed."""
    if state.exports.under_way is not request:
        return
    if isinstance(answer, Failure):
        state.exports.under_way = None
        actions.fail(state, f"the export failed: {answer.message}")
    elif answer.path is not None:
        state.exports.under_way = None
        actions.announce(state, f"exported {answer.path.name} in {located(answer.path.parent)}")
    else:
        state.exports.pace = state.exports.pace.after(answer.done, state.window.now)


def take_saved(state: AppState, request: object, answer: Step | Failure) -> None:
    """The picture of what is shown has been written, or has not."""
    if isinstance(answer, Failure):
        actions.fail(state, f"the image was not saved: {answer.message}")
    elif answer.path is not None:
        actions.announce(state, f"saved {answer.path.name} in {located(answer.path.parent)}")


def cancelled(state: AppState) -> None:
    """Nothing has been written."""
    state.exports.under_way = None
    actions.announce(state, "export cancelled")


def show_exports(state: AppState, shown: bool) -> None:
    """The panel."""
    state.exports.shown = shown


def choose_sizing(state: AppState, sizing: Sizing) -> None:
    """Of the panes."""
    state.exports.sizing = sizing


def choose_view_size(state: AppState, size: tuple[int, int] | None) -> None:
    """Pixels of the 3D view in files; None: its shape on screen."""
    state.exports.view_size = size


def choose_supersampling(state: AppState, factor: int) -> None:
    """How often finer the 3D view is drawn, one of FACTORS."""
    state.exports.supersampling = factor
