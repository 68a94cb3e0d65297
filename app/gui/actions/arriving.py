"""Takes over what has been opened: the start of a session with it. Functions on the state."""

from __future__ import annotations

from pathlib import Path

from app.gui.actions import actions, clip_actions, enhancement_actions, masking_actions, session_actions
from app.gui.state.app_state import AppState
from app.gui.state.masking import Masking
from app.gui.state.reconstruction import Reconstruction
from app.gui.state.scene import CameraList, Second, Viewer
from app.gui.state.source import Reports
from app.gui.views.picture_view import PictureView
from app.gui.work.depths import DepthRequest
from app.gui.work.opening import Opened
from app.gui.work.settings import UNKNOWN
from assets import phantom_path
from renderer.clip import Clip
from renderer.view_files import Views


def show_opened(state: AppState, path: Path, opened: Opened) -> None:
    """Take over what has been opened: the start of a session with it, but for a report, which joins it."""
    if opened.report is not None:
        state.source.opening, state.reports = None, Reports(opened.report, asked=True)
        actions.say(state, f"opened {path.name}")
        return
    again, before, making = _is_same_clip(state, opened), state.source.clip, state.masking.making
    _take_source(state, path, opened)
    _look_anew(state, opened, again=again)
    if not state.runs.reconstruction.is_alive:
        _show_run(state, opened, again=again)
    enhancement_actions.rebase(state, [step.params for step in state.enhancement.past])
    for notice in opened.notices:
        actions.say(state, notice)
    actions.say(state, f"opened {path.name}")
    if _begins_with_notes(state, before, opened):
        actions.announce(
            state, "Notes and case summary continue: for another patient, choose File > New case"
        )
    if opened.warning:
        actions.fail(state, opened.warning)
    if opened.lost is not None:
        actions.fail(state, str(opened.lost))
        session_actions.offer_to_find(state, opened.lost)
    masking_actions.tell_interrupted(state, making)
    # What a crash left is this process's own from now on: nothing to open another time.
    if not opened.in_passing and path.parent != state.places.config:
        _remember(state, path)


def _remember(state: AppState, path: Path) -> None:
    """Under Recent, and where the next dialog begins: what is opened next often lies beside it."""
    is_own = path == phantom_path() or path.is_relative_to(state.places.runs)
    state.settings = state.settings.opened(path)
    actions.visit(state, path.parent, *(() if is_own else ("file", "folder")))  # Writes both at once.


def _take_source(state: AppState, path: Path, opened: Opened) -> None:
    """What is open, how it was read, and what is known of it."""
    source, clip = state.source, opened.clip
    clip_actions.keep_views(state)
    if not goes_on(state, opened):
        state.session.path, state.session.discarded, state.session.is_unsaved = None, None, False
    if clip is None or source.clip is None or clip.path != source.clip.path:
        known = source.known.get(str(clip.path if clip is not None else opened.path or path), UNKNOWN)
        state.scene.cameras = CameraList(known.views or Views())
    source.opening, source.asked = None, True
    # A session of notes alone has no source.
    source.path = opened.path if opened.session is not None else opened.path or path
    source.clip, source.options, source.content = clip, opened.options, opened.content
    source.bare, source.is_enhanced, source.depth_ways = opened.bare, opened.is_enhanced, None
    source.is_dicom = opened.is_dicom
    source.notices, source.depth_wish = opened.to_be_read, _kept_depth(state, opened)
    source.tool_masks = None
    said = source.known.get(str(clip.path), UNKNOWN) if clip is not None else UNKNOWN
    source.part = opened.run.record.clip.part if opened.run is not None else said.part


def _look_anew(state: AppState, opened: Opened, *, again: bool) -> None:
    """Nothing is left of what was made for the clip before; `again`: what one looks at stays."""
    state.picture.pictures, state.picture.measured = None, None
    state.picture.left_out, state.picture.mask_tool = None, ""
    state.timeline.playing, state.timeline.frozen_index, state.timeline.strip = False, None, None
    if not again:
        state.picture.view = PictureView(pixel_aspect=opened.clip.pixel_aspect if opened.clip else 1.0)
        state.scene.linked, state.scene.own_time, state.timeline.frame_index = True, 0.0, 0
    state.tuning = state.tuning.renewed()
    state.comparing.chosen = state.comparing.chosen.renewed()
    state.comparing.others, state.comparing.difference = {}, None
    state.exports.failure = ""
    state.masking = Masking(radius=state.masking.radius)


def show_without_run(state: AppState, clip: Clip) -> None:
    """The run that was shown is there no longer: its clip, which is open, goes on alone."""
    alone = Opened(clip)
    state.source.path, state.source.content = clip.path, alone.content
    _show_run(state, alone, again=True)


def goes_on(state: AppState, opened: Opened) -> bool:
    """The session goes on with it, in its file: another run of the clip that is open."""
    return opened.run is not None and _is_same_clip(state, opened)


def _begins_with_notes(state: AppState, before: Clip | None, opened: Opened) -> bool:
    """What was written of another clip is still there; a case may have several."""
    if before is None or opened.clip is None or opened.session is not None or opened.in_passing:
        return False
    return before.path != opened.clip.path and session_actions.has_case(state)


def _kept_depth(state: AppState, opened: Opened) -> DepthRequest | None:
    """What was chosen for this clip, to be read while its frames are shown already: it may take long."""
    clip, bare = opened.clip, opened.bare
    if clip is None or bare is None or opened.run is not None or opened.session is not None:
        return None
    options = state.source.kept_options(clip.path, opened.options)
    return DepthRequest(bare, options) if options != opened.options and bare.has_one_size else None


def _is_same_clip(state: AppState, opened: Opened) -> bool:
    """Its frames are shown already, as with another run of it: what one looks at stays."""
    before, now = state.source.clip, opened.clip
    if before is None or now is None or opened.session is not None:
        return False
    return (before.path, before.labels, before.size) == (now.path, now.labels, now.size)


def _show_run(state: AppState, opened: Opened, *, again: bool) -> None:
    draft, before = state.runs.reconstruction, state.scene.model
    state.runs.reconstruction = Reconstruction(config=draft.config, input=draft.input, kept=draft.kept)
    state.scene.model, state.scene.view = opened.splats, None
    state.runs.model_wish = None
    state.scene.second = Second()
    now = opened.run.model if opened.run is not None else None
    is_seen_alike = again and before is not None and now is not None and before.cameras == now.cameras
    state.scene.viewer = state.scene.viewer.renewed() if is_seen_alike else Viewer()
    if opened.run is None:
        return
    record, run = opened.run.record, opened.run
    state.scene.model = now
    state.runs.reconstruction = Reconstruction(
        config=record.config,
        input=record.input,
        clip=opened.clip,
        request=run.request,
        status="finished" if run.is_finished else "elsewhere" if run.is_trained else "cancelled",
        has_checkpoint=run.model is not None,
        progress=run.told.progress[-1] if run.told.progress else None,
        told=run.told,
    )
