"""What a user can do with many files and folders at once, as functions on the state."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

from app.enhancement.enhance_files import Setting
from app.enhancement.methods import preset_of
from app.enhancement.settable import Pixels, Scope
from app.enhancement.setting_words import with_method
from app.files.legible import located
from app.files.provenance import stamp
from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.work.background import Failure
from app.gui.work.batching import NAMED, BatchRequest, Progressed
from app.gui.work.revealing import RevealRequest
from renderer.readers.clip_options import ClipOptions

SCOPES_SAID: Final[Mapping[Scope, str]] = {
    "automatic": "each recording as a whole",
    "image": "each image on its own",
    "clip": "each clip as a whole",
}
PIXELS_SAID: Final[Mapping[Pixels, str]] = {
    "automatic": "field of view alone",
    "all": "all pixels",
    "tissue": "statistics of tissue only",
}

WEB: Final = (("http:",), ("https:",))
"""How the path of what was dragged out of a browser begins."""
OF_THE_WEB: Final = (
    "expected a file or a folder, got an address on the web: save it there first, then drop the file here"
)


def add_input(state: AppState, path: Path) -> None:
    """Add a file or a folder to the batch, unless it is there already."""
    if path.absolute() not in state.batches.inputs:
        state.batches.inputs = (*state.batches.inputs, path.absolute())


def take_dropped(state: AppState, paths: Sequence[Path]) -> None:
    """On the window: all join the batch whose window is shown; without it the first is opened."""
    files = tuple(path for path in paths if path.parts[:1] not in WEB)
    if len(files) < len(paths):
        actions.fail(state, OF_THE_WEB)
    if files and not state.batches.shown:
        actions.open_first(state, files)
        return
    for path in files:
        add_input(state, path)


def remove_input(state: AppState, place: int) -> None:
    inputs = state.batches.inputs
    state.batches.inputs = inputs[:place] + inputs[place + 1 :]


def clear_inputs(state: AppState) -> None:
    state.batches.inputs = ()


def results_folder(state: AppState) -> Path:
    """Where the folder of the next results is made."""
    return state.folder_of("results") or state.places.pictures


def summary(state: AppState) -> str:
    """The current settings in a line."""
    chosen = state.enhancement
    return f"{with_method(chosen.params)} · {SCOPES_SAID[chosen.scope]} · {PIXELS_SAID[chosen.pixels]}"


def present_setting(state: AppState) -> Setting:
    """How files are enhanced: as the Enhancement panel says, and read as was said at the start."""
    chosen, reading = state.enhancement, _reading(state.source.clip_options)
    return Setting(preset_of(chosen.params), chosen.params, chosen.scope, chosen.pixels, reading)


def _reading(options: ClipOptions) -> ClipOptions:
    """What of them counts for files that are enhanced: all frames, without depth."""
    return ClipOptions(
        deinterlacing=options.deinterlacing,
        calibration=options.calibration,
        stereo=options.stereo,
        bits=options.bits,
    )


def why_not_start(state: AppState) -> str:
    """What a batch still lacks, in a sentence; empty when it can start."""
    if state.batches.under_way is not None:
        return "A batch is already running."
    return "" if state.batches.inputs else "Add files or folders first."


def batch_request(state: AppState) -> BatchRequest | None:
    """The batch by the present setting, which is then under way; None where `why_not_start` says why."""
    if why_not_start(state):
        return None
    target = results_folder(state) / f"{NAMED}{stamp()}"
    own = {path: _reading(state.source.first_options(Path(path))) for path in state.source.known}
    request = BatchRequest(state.batches.inputs, target, present_setting(state), own)
    state.batches.under_way, state.batches.progressed, state.batches.written = request, None, None
    return request


def take_progress(state: AppState, request: BatchRequest, answer: Progressed | Failure) -> None:
    """Take what the background work reports of a batch: progress, its end, or why it failed."""
    batches = state.batches
    if batches.under_way is not request:
        return
    if isinstance(answer, Failure):
        _stopped(state, request, answer)
        return
    batches.progressed = answer
    if answer.has_ended:
        batches.under_way = None
        _tell(state, request, answer)


def _stopped(state: AppState, request: BatchRequest, failure: Failure) -> None:
    """The batch ends with an error; finished files are kept."""
    batches, now = state.batches, state.batches.progressed
    batches.under_way = None
    if now is None or not _written(now):
        actions.fail(state, f"nothing was enhanced: {failure.message}")
        return
    batches.written = request.output
    done = f"{_written(now)} of {now.step.count} enhanced into {located(request.output)}"
    actions.fail(state, f"{done}, then the batch stopped: {failure.message}")


def _tell(state: AppState, request: BatchRequest, answer: Progressed) -> None:
    count, folder = answer.step.count, located(request.output)
    done = _written(answer)
    state.batches.written = request.output if done else None
    for note in answer.noted:
        actions.say(state, f"{note.name}: {note.notice}")
    for one in answer.failed:
        actions.say(state, f"{one.name} could not be enhanced: {one.reason}")
    said, losses = _told(done, count, folder), tuple(_losses(answer))
    if losses:
        said = f"{'; '.join((said, *losses))}: see the list"
    elif answer.noted:
        said = f"{said}; the list has notices"
    state.batches.shown = state.batches.shown or bool(losses)
    tell = actions.fail if losses else actions.announce
    tell(state, said)


def _told(done: int, count: int, folder: str) -> str:
    """How many came of so many files and folders; one is not counted: it may be a folder of many images."""
    if not done:
        return "nothing was enhanced"
    return f"{done} of {count} enhanced into {folder}" if count > 1 else f"enhanced into {folder}"


def _losses(answer: Progressed) -> Iterator[str]:
    """What is lacking: items, images of folders, and parts of videos."""
    images = sum(bool(one.image) for one in answer.failed)
    if items := len(answer.failed) - images:
        yield f"{items} could not be enhanced"
    if images:
        yield f"{images} image{'s' if images > 1 else ''} could not be read"
    if any(note.is_loss for note in answer.noted):
        yield "not all of it could be read"


def _written(answer: Progressed) -> int:
    """Items of which there is something."""
    return answer.step.place - sum(not one.image for one in answer.failed)


def cancelled(state: AppState) -> None:
    """The batch was cancelled: finished files are kept, the one under way is not."""
    batches, request = state.batches, state.batches.under_way
    batches.under_way = None
    if request is not None and batches.progressed is not None and _written(batches.progressed):
        batches.written = request.output
    actions.announce(state, "batch cancelled; finished files are kept")


def reveal(state: AppState) -> None:
    """The results of the last one in the system's file manager."""
    if state.batches.written is not None:
        state.window.wishes += (RevealRequest(state.batches.written),)
