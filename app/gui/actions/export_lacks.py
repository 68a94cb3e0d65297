"""Why something cannot be exported now, in a sentence."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Final

from app.enhancement.settable import RENDER
from app.exports.splats import fourdgs
from app.exports.usd_file import NO_USD, has_usd
from app.files.codecs import HEVC, WEBM
from app.files.legible import capital
from app.files.video_encoder import NO_ENCODER, is_encoded
from app.gui.actions.clip_actions import why_no_clip
from app.gui.actions.export_offers import Offer
from app.gui.actions.export_records import format_of, sized
from app.gui.state.app_state import AppState
from app.gui.state.panes import why_not
from app.live.picture import LIVE
from renderer.readers.dicom.opening import NO_PYDICOM, has_pydicom

NO_CLIP: Final = "Open a clip first."
NO_MODEL: Final = "There is no 3D model yet: reconstruct the clip or open a run."
HIDDEN: Final = "The 3D view is hidden: bring its tab to the front first."
NO_PATH: Final = "There is no camera path yet: create one in the Cameras panel."
UNFINISHED: Final = "The reconstruction is not finished: wait for it or continue it."
ONE_IMAGE: Final = "One image is no video: choose what is under Image."
SIZES_DIFFER: Final = "The images differ in size: no video can show them."
MOST_DRAWN = 2**25
"""Pixels of the 3D view drawn at once: 3840 × 2160 at 2×, some 0.7 GB while they are averaged."""
PACKAGES: Final[Mapping[str, tuple[Callable[[], bool], str]]] = {
    ".usdc": (has_usd, NO_USD),
    fourdgs.SUFFIX: (fourdgs.has_fourdgs, fourdgs.NO_FOURDGS),
    ".dcm": (has_pydicom, NO_PYDICOM),
    WEBM: (partial(is_encoded, WEBM), NO_ENCODER),
    HEVC: (partial(is_encoded, HEVC), NO_ENCODER),
}
"""Of formats that need one: whether it is there, and what to say where it is not."""


def lacks(state: AppState, offer: Offer) -> str:
    """What there is nothing to show for, then what nothing can write here."""
    return _lacks_content(state, offer) or _lacks_package(format_of(state, offer.form))


def _lacks_content(state: AppState, offer: Offer) -> str:
    if offer.is_of_model:
        return _lacks_model(state, offer)
    if offer.is_dicom:
        return _lacks_dicom(state, offer)
    needs_view = offer.sees != "no" and not (offer.sides and state.source.clip is not None)
    if needs_view and state.plain_view_request is None:
        return NO_MODEL if state.scene.model is None else HIDDEN
    if offer.sees != "no" and (reason := _too_large(state)):
        return reason
    if offer.form == "view video" and state.scene.model is not None and state.scene.model.live:
        return UNFINISHED
    if offer.sees == "path" and not state.scene.cameras.views.path.keyframes:
        return NO_PATH
    seen = offer.sees == "time" and state.scene.viewer.snapped
    if offer.form == "view video" and state.scene.kind == "difference" and not seen:
        return "A difference is shown from the clip's camera only: press C or choose another view."
    if not offer.sides or (offer.sees == "still" and state.source.clip is None):
        return ""
    if state.source.clip is None:
        return NO_CLIP
    if offer.form == "panes video" and len(state.source.clip) == 1:
        return why_no_clip(state) or ONE_IMAGE
    if offer.form == "panes video" and not state.source.clip.has_one_size:
        return SIZES_DIFFER
    if offer.as_shown:
        return ""
    sources = [state.comparing.chosen.source(side) for side in offer.sides]
    reasons = (why_not(state, source) for source in sources)
    missing = next((reason for reason in reasons if reason), "")
    return missing or (_covers_less(state) if offer.form != "picture" and RENDER in sources else "")


def _covers_less(state: AppState) -> str:
    """Why the open reconstruction cannot stand beside every frame from In to Out."""
    model, (first, last) = state.scene.model, state.source.span
    if model is None or (model.has_clip_frame(first) and model.has_clip_frame(last)):
        return ""
    start, end = model.start + 1, model.start + len(model.cameras)
    return f"The reconstruction covers frames {start} to {end}: set In and Out within them."


def _lacks_dicom(state: AppState, offer: Offer) -> str:
    clip = state.source.clip
    if clip is None:
        return NO_CLIP
    if clip.format == LIVE:
        return "A live frame is in no file yet: save the image, then open it."
    if offer.form == "DICOM video" and len(clip) == 1:
        return "One image is no video: export the enhanced frame."
    if offer.form == "DICOM video" and not clip.has_one_size:
        return SIZES_DIFFER
    if state.exports.dicom.keep_identity and not state.source.is_dicom:
        return "The source is not DICOM: there is no patient to keep."
    return ""


def _lacks_package(suffix: str) -> str:
    is_there, lacking = PACKAGES.get(suffix, (lambda: True, ""))
    return "" if is_there() else f"{capital(lacking)}."


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


def _lacks_model(state: AppState, offer: Offer) -> str:
    model = state.scene.model
    if model is None:
        return NO_MODEL
    if offer.form != "cameras" and model.live:
        return UNFINISHED
    if model.is_series and offer.traits.is_of_tissue:
        return f"This is {model.split_by_time}, not one model that moves."
    if offer.form == "tracks" and not _is_measured(state):
        return "Nothing is measured yet: press M and click the tissue in the 3D view."
    if offer.sees == "path" and not state.scene.cameras.views.path.keyframes:
        return NO_PATH
    return ""


def _is_measured(state: AppState) -> bool:
    """A point of the model that is open."""
    model, measured = state.scene.model, state.scene.viewer.measurement
    return model is not None and bool(measured.points) and measured.of == model.identity
