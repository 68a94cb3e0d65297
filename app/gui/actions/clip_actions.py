"""Trimming and masking a clip, its eyes and its calibration, as functions on the state."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from app.enhancement.image_mask import NO_MASK, PictureMask, enclosing
from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.work.keeping import KeepClip
from app.gui.work.opening import OpenRequest
from app.gui.work.settings import UNKNOWN, KnownClip
from app.runs.clip_selection import ClipPart
from enhance.field_search import find_field
from renderer.readers.clip_options import ClipOptions, Stereo
from renderer.readers.image_folders.frames import is_seen_by_assumption


def why_no_clip(state: AppState) -> str:
    """Why there is none to work on, in a sentence; empty where there is one."""
    if state.source.clip is None:
        return "Open a clip first."
    return "Record the live source, then open the recording." if state.source.is_live_frame else ""


def why_not_trimmed(state: AppState) -> str:
    """Why there is nothing to shorten, in the same way."""
    return why_no_clip(state) or ("" if state.moments > 1 else "A single image has no other frames.")


def dismiss_notices(state: AppState) -> None:
    """What is said of the open video has been read."""
    state.source.notices = ()


def trim_here(state: AppState, *, start: bool) -> None:
    """The clip begins, or ends, with the present frame; where that lies beyond the other end, this goes back
    to that of the whole."""
    if state.source.clip is None:
        return
    first, last = state.source.span
    now, end = state.timeline.frame_index, len(state.source.clip) - 1
    first, last = (now, last if now <= last else end) if start else (first if first <= now else 0, now)
    whole = (first, last) == (0, end)
    _set(state, replace(state.source.part, trim=None if whole else (first, last)))


def untrim(state: AppState) -> None:
    _set(state, replace(state.source.part, trim=None))


def set_mask(state: AppState, mask: PictureMask) -> None:
    """Live, while it is drawn; `keep_settings` writes it down."""
    state.source.part = replace(state.source.part, mask=mask)


def draw_mask(state: AppState, shape: str) -> None:
    """The next drag over a picture draws this: "text", "view", or nothing for ""."""
    state.picture.mask_tool = "" if state.picture.mask_tool == shape else shape
    state.picture.overlay = state.picture.overlay or bool(state.picture.mask_tool)


def begin_mask(state: AppState, at: tuple[float, float]) -> None:
    """A drag that draws the mask starts here in the picture."""
    state.picture.mask_start = at


def finish_mask(state: AppState) -> None:
    """The mouse button is released: the drawn mask counts."""
    state.picture.mask_tool, state.picture.mask_start = "", None
    keep_settings(state)


def stop_mask(state: AppState) -> None:
    """Nothing is drawn: a drag that has begun leaves the mask as it was before it."""
    if state.picture.mask_start is not None:
        set_mask(state, state.enhancement.past[-1].part.mask)
    state.picture.mask_tool, state.picture.mask_start = "", None


def round_view(state: AppState) -> None:
    """The circle of the field of view of the present picture."""
    if state.picture.pictures is None:
        return
    field = find_field(state.picture.pictures.original)
    aspect = state.picture.view.pixel_aspect
    circle = (field.circle or enclosing(field.mask(), aspect)) if field is not None else None
    if circle is None:
        actions.announce(state, "this frame has no dark surround")
        return
    set_mask(state, replace(state.source.part.mask, view=circle))
    state.picture.overlay = True
    keep_settings(state)


def clear_mask(state: AppState) -> None:
    set_mask(state, NO_MASK)
    finish_mask(state)


def toggle_overlay(state: AppState) -> None:
    """Tint tools and what is masked."""
    state.picture.overlay = not state.picture.overlay


def _set(state: AppState, settings: ClipPart) -> None:
    state.source.part = settings
    keep_settings(state)


def keep_reading(state: AppState, options: ClipOptions) -> None:
    """Depth, baseline, field of view, eyes and calibration that were chosen for this clip."""
    if state.source.clip is not None:
        path = str(state.source.clip.path)
        chosen = replace(
            state.source.known.get(path, UNKNOWN),
            depth=options.depth,
            baseline=options.baseline,
            view_angle=options.field_of_view,
            stereo=options.stereo,
            calibration=options.as_asked.calibration,
        )
        _keep(state, path, chosen)


def is_video(state: AppState) -> bool:
    """A video is open by itself: nothing has been made of it that would be of another size."""
    clip = state.source.clip
    return clip is not None and clip.format == "video" and state.source.path == clip.path


def choose_eyes(state: AppState, stereo: Stereo) -> None:
    """Open the video again, with its frames read so; what is unsaved comes first."""
    clip = state.source.clip
    if clip is None or not is_video(state) or stereo == state.source.options.stereo:
        return
    options = replace(state.source.first_options(clip.path), stereo=stereo)
    actions.open_request(state, OpenRequest(clip.path, options))


def may_be_calibrated(state: AppState) -> bool:
    """The open clip brings no calibration of its own, and nothing has been made of it."""
    bare = state.source.bare
    if bare is None or state.source.is_live_frame or state.source.path != bare.path:
        return False
    return bare.has_one_size and (bare.calibrated or is_seen_by_assumption(bare))


def choose_calibration(state: AppState, path: Path) -> None:
    """Open the clip again, undistorted by that of a file; what is unsaved comes first."""
    if (clip := state.source.clip) is not None:
        options = state.source.first_options(clip.path)
        actions.open_request(state, OpenRequest(clip.path, options, calibration=path))


def drop_calibration(state: AppState) -> None:
    """Open the clip again as its files are."""
    if (clip := state.source.clip) is not None:
        options = replace(state.source.first_options(clip.path), calibration=None)
        actions.open_request(state, OpenRequest(clip.path, options))


def keep_lens(state: AppState, request: OpenRequest) -> None:
    """Eyes and calibration as they were chosen, once the clip could be opened so."""
    clip, said = state.source.clip, state.source.clip_options
    if clip is None or clip.path != request.path:
        return
    known = state.source.known.get(str(clip.path), UNKNOWN)
    stereo, calibration = request.options.stereo, state.source.options.calibration
    if stereo == said.stereo and known.stereo == UNKNOWN.stereo:
        stereo = known.stereo
    if calibration is not None and calibration == said.calibration:
        calibration = known.calibration
    if (stereo, calibration) != (known.stereo, known.calibration):
        _keep(state, str(clip.path), replace(known, stereo=stereo, calibration=calibration))


def keep_settings(state: AppState) -> None:
    """For the next time that this clip is opened, where paths are remembered at all."""
    if state.source.clip is not None:
        path = str(state.source.clip.path)
        _keep(state, path, state.source.known.get(path, UNKNOWN))


def _keep(state: AppState, path: str, reading: KnownClip) -> None:
    """The part as it is now, and how the clip is read."""
    part = state.source.part
    _know(state, path, replace(reading, trim=part.trim, mask=part.mask))


def keep_views(state: AppState) -> None:
    """Named views and the camera path for the next time that what they are of is opened, unless a session's
    file holds them."""
    source, views = state.source, state.scene.cameras.views
    path = source.clip.path if source.clip is not None else source.path
    if path is None or state.session.path is not None:
        return
    known = source.known.get(str(path), UNKNOWN)
    made = views if views.named or views.path.keyframes else None
    if made != known.views:
        _know(state, str(path), replace(known, views=made))


def _know(state: AppState, path: str, known: KnownClip) -> None:
    before = state.source.known.get(path, UNKNOWN)
    state.source.known = {**state.source.known, path: known}
    if state.settings.remember_recent:
        state.window.wishes += (KeepClip(state.places.config, path, known, before),)
