"""What a user can export, as functions on the state."""

from __future__ import annotations

from pathlib import Path

from app.exports.camera_set import ENDINGS, CameraSet
from app.exports.exporting import ExportRequest, Step
from app.exports.sizing import Sizing
from app.files.dicom.choices import DicomChoices
from app.files.legible import located
from app.files.video_encoder import VideoEncoder
from app.gui.actions import actions, live_actions
from app.gui.actions.export_lacks import lacks
from app.gui.actions.export_names import default_name, why_not_name
from app.gui.actions.export_offers import OFFERS, Form
from app.gui.actions.export_records import format_of, request_of
from app.gui.state.app_state import AppState
from app.gui.state.exports import What
from app.gui.state.pace import Pace
from app.gui.work.background import Failure
from app.gui.work.naming import NameRequest
from app.gui.work.revealing import RevealRequest
from renderer.camera_files import off_center

MOST_SAVING = 64
"""Images of what is shown that wait to be written; each keeps alive what it is of."""
SETTLING = 3
"""Frames after which the menu or the panel that was clicked has gone."""


def choose_what(state: AppState, what: What) -> None:
    """The next export is of this, in the panel, by its own name; why another failed is no longer shown."""
    if what != state.exports.what:
        state.exports.what, state.exports.name, state.exports.failure = what, "", ""
    state.exports.shown = True


def why_not_export(state: AppState, what: What) -> str:
    """What it still lacks, in a sentence; empty when it can start."""
    if state.exports.under_way is not None:
        return "Another export is running."
    return lacks(state, OFFERS[what])


def stem_of(state: AppState) -> str:
    """The name in the panel, without suffix."""
    return state.exports.name.strip() or default_name(state, state.exports.what)


def suffix_of(state: AppState) -> str:
    """Of what is chosen in the panel; empty for a folder."""
    offer = OFFERS[state.exports.what]
    return "" if offer.traits.is_folder else format_of(state, offer.form)


def why_not_start(state: AppState) -> str:
    """What the export that is chosen in the panel still lacks."""
    return why_not_export(state, state.exports.what) or why_not_name(stem_of(state))


def start(state: AppState) -> None:
    """What is chosen in the panel, by the name there."""
    if not why_not_start(state):
        export_request(state, state.exports.what, stem_of(state))


def export_request(state: AppState, what: What, stem: str = "") -> ExportRequest | None:
    """The export as things stand now, which is then under way; None where `why_not_export` says why, and for
    the window, which is saved when it is as it should be seen."""
    if why_not_export(state, what):
        return None
    if what == "window":
        save_window(state)
        return None
    seen = live_actions.held(state)
    request = request_of(seen, what, stem or default_name(seen, what))
    begin(state, request)
    _say_what_shifts(state, request)
    return request


def begin(state: AppState, request: ExportRequest) -> None:
    """Have the background work make this export from now on."""
    state.exports.under_way, state.exports.pace, state.exports.failure = request, Pace(), ""


def _say_what_shifts(state: AppState, request: ExportRequest) -> None:
    """Log a notice of cameras whose principal point some programs do not read."""
    cameras = request.record
    if not isinstance(cameras, CameraSet) or request.suffix != ENDINGS["splatting"]:
        return
    if notice := off_center(cameras.named):
        actions.say(state, notice)


def why_not_save(state: AppState) -> str:
    """What an image of all that is shown lacks, in a sentence; empty when it can be saved."""
    return _waits(state) or lacks(state, OFFERS["panes and 3D view"])


def _waits(state: AppState) -> str:
    """Why no more images can be asked for until some are written; empty when they can."""
    count = len(state.exports.saving)
    return f"{count} images are still being saved." if count >= MOST_SAVING else ""


def save_picture(state: AppState) -> None:
    """A PNG of what is shown, written in the background beside whatever is exported."""
    if reason := why_not_save(state):
        actions.fail(state, f"the image was not saved: {reason}")
    elif (request := shown_request(state)) is not None:
        ask_image(state, request)


def ask_image(state: AppState, request: ExportRequest) -> None:
    """An image of what is shown, to be written in the background; until it is, closing the window asks."""
    state.exports.saving += (request,)
    state.window.wishes += (request,)


def save_window(state: AppState) -> None:
    """Ask for the window as it is once what was clicked has gone."""
    if reason := _waits(state):
        actions.fail(state, f"the image was not saved: {reason}")
    else:
        state.exports.settling = SETTLING


def shown_request(state: AppState) -> ExportRequest | None:
    """What there is to see of panes and 3D view, as PNG; None where there is neither."""
    what: What = "panes and 3D view"
    if state.source.clip is None and state.plain_view_request is None:
        return None
    seen = live_actions.held(state)
    return request_of(seen, what, default_name(seen, what), ".png")


def name_wish(state: AppState) -> NameRequest | None:
    """Whether the name of what is being written is free or else, while the panel is shown, the one there."""
    if (under_way := state.exports.under_way) is not None:
        return NameRequest(under_way.folder, under_way.stem, under_way.suffix, state.exports.count)
    if not state.exports.shown or why_not_name(stem_of(state)):
        return None
    return NameRequest(state.export_folder, stem_of(state), suffix_of(state), state.exports.count)


def take_name(state: AppState, request: NameRequest, answer: str | Failure) -> None:
    if isinstance(answer, str):
        state.exports.named = request, answer


def other_name(state: AppState) -> str:
    """By which it is written since the name that was wished for is taken; empty where that is free."""
    asked, wanted = state.exports.named, name_wish(state)
    return asked[1] if asked is not None and asked[0] == wanted and asked[1] != asked[0].name else ""


def added_to_name(state: AppState) -> str:
    """What the other name has more; empty where the name is free."""
    return other_name(state).removesuffix(suffix_of(state)).removeprefix(stem_of(state))


def name_written(state: AppState) -> str:
    """The name of the export under way; empty for none."""
    request = state.exports.under_way
    return "" if request is None else other_name(state) or f"{request.stem}{request.suffix}"


def encoder_wish(state: AppState) -> str | None:
    """What writes videos, once the panel is shown."""
    return "video encoder" if state.exports.shown else None


def take_encoder(state: AppState, request: object, answer: VideoEncoder | Failure) -> None:
    if isinstance(answer, VideoEncoder):
        state.exports.encoder = answer


def take_step(state: AppState, request: ExportRequest, answer: Step | Failure) -> None:
    """Take what the background work reports of an export: progress, its end, or why it failed."""
    if state.exports.under_way is not request:
        return
    if isinstance(answer, Failure):
        state.exports.under_way = None
        _not_written(state, "the export failed", request, answer)
    elif answer.path is not None:
        state.exports.under_way = None
        _written(state, "exported", answer.path)
    else:
        state.exports.pace = state.exports.pace.after(answer.done, state.window.now)


def take_saved(state: AppState, request: ExportRequest, answer: Step | Failure) -> None:
    """The picture of what is shown has been written, or has not."""
    if isinstance(answer, Failure) or answer.path is not None:
        state.exports.saving = tuple(one for one in state.exports.saving if one is not request)
    if isinstance(answer, Failure):
        _not_written(state, "the image was not saved", request, answer)
    elif answer.path is not None:
        _written(state, "saved", answer.path)


def _not_written(state: AppState, how: str, request: ExportRequest, answer: Failure) -> None:
    """What the system says of the file to be written is told with its folder: it may be on another disk than
    one thinks."""
    file = answer.error.filename if isinstance(answer.error, OSError) else None
    is_ours = file is not None and Path(str(file)).is_relative_to(request.folder)
    place = f" in {located(request.folder)}" if is_ours else ""
    state.exports.last, state.exports.failure = None, f"{answer.message}{place}"
    actions.fail(state, f"{how}: {state.exports.failure}")


def _written(state: AppState, how: str, path: Path) -> None:
    state.exports.last, state.exports.failure = path, ""
    state.exports.count += 1
    actions.announce(state, f"{how} {path.name} in {located(path.parent)}")


def reveal(state: AppState) -> None:
    """The newest exported file in the system's file manager."""
    if state.exports.last is not None:
        state.window.wishes += (RevealRequest(state.exports.last),)


def take_revealed(state: AppState, request: RevealRequest, answer: Path | Failure) -> None:
    if isinstance(answer, Failure):
        actions.fail(state, answer.message)


def cancelled(state: AppState) -> None:
    """The export has been given up; nothing has been written."""
    state.exports.under_way = None
    actions.announce(state, "export cancelled")


def choose_sizing(state: AppState, sizing: Sizing) -> None:
    """Choose how large exported panes are."""
    state.exports.sizing = sizing


def choose_view_size(state: AppState, size: tuple[int, int] | None) -> None:
    """Pixels of the 3D view in files; None: its shape on screen."""
    state.exports.view_size = size


def choose_supersampling(state: AppState, factor: int) -> None:
    """How often finer the 3D view is drawn, one of FACTORS."""
    state.exports.supersampling = factor


def type_name(state: AppState, name: str) -> None:
    """Of the next export; the suffix is known without being typed."""
    state.exports.name = name.removesuffix(suffix_of(state)) if suffix_of(state) else name


def choose_format(state: AppState, form: Form, suffix: str) -> None:
    """Choose one of the formats of an export."""
    state.exports.formats[form] = suffix


def choose_dicom(state: AppState, choices: DicomChoices) -> None:
    """Choose what DICOM files hold of the patient."""
    state.exports.dicom = choices


def choose_quality(state: AppState, quality: int) -> None:
    """Choose the quality of JPEG images, 1 to 100."""
    state.exports.quality = min(max(quality, 1), 100)


def choose_degree(state: AppState, degree: int | None) -> None:
    """Of the harmonics in splat files; None: the model's."""
    state.exports.sh_degree = degree


def choose_unobserved(state: AppState, kept: bool) -> None:
    """Whether splat files hold Gaussians that no frame shows."""
    state.exports.unobserved = kept
