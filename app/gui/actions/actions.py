"""Messages, settings, opening, and the time of the clip, as functions on the state. No ImGui, no OpenGL."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from app.files.legible import legible
from app.gui.state.app_state import AppState
from app.gui.state.choosing import Choosing, Kind, Purpose
from app.gui.state.window import Banner, Toast
from app.gui.work.keeping import KeepSettings
from app.gui.work.opening import VIEW_SUFFIXES, OpenRequest
from app.gui.work.settings import Settings, Theme
from app.runs.run_folder import RunFolder
from app.scenes.backgrounds import BackgroundName
from assets import phantom_path

TOAST_SECONDS = 6.0
log = logging.getLogger(__name__)


def say(state: AppState, line: str) -> None:
    """Add a line to the log panel."""
    state.window.log.append(legible(line))


def fail(state: AppState, sentence: str) -> None:
    """Show what went wrong until it is dismissed."""
    state.window.banner = Banner(legible(sentence))
    say(state, sentence)
    log.info("shown: %s", legible(sentence))


def dismiss(state: AppState) -> None:
    """Take away the error that is shown: it has been read."""
    state.window.banner = None


def show_help(state: AppState, shown: bool) -> None:
    """Show or hide the list of every key and gesture."""
    state.window.help_open = shown


def announce(state: AppState, sentence: str) -> None:
    """Show what went well for a few seconds."""
    state.window.toast = Toast(legible(sentence), state.window.now + TOAST_SECONDS)
    say(state, sentence)


def acknowledge(state: AppState) -> None:
    """The first-start notice has been read."""
    use_settings(state, replace(state.settings, acknowledged=True))


def choose_theme(state: AppState, theme: Theme) -> None:
    use_settings(state, replace(state.settings, theme=theme))


def choose_background(state: AppState, name: BackgroundName) -> None:
    """Choose what reconstructions show where nothing was observed."""
    use_settings(state, replace(state.settings, background=name))


def toggle_unobserved(state: AppState) -> None:
    """Show what no frame of a reconstruction shows, or leave it out."""
    use_settings(state, replace(state.settings, unobserved=not state.settings.unobserved))


def resize_text(state: AppState, steps: int) -> None:
    """Make all text larger by so many steps, or smaller where negative."""
    use_settings(state, state.settings.resized(steps))


def choose_text_size(state: AppState, percent: int) -> None:
    use_settings(state, replace(state.settings, text_percent=percent))


def remember_recent(state: AppState, remember: bool) -> None:
    use_settings(state, state.settings.remembering(remember))


def use_settings(state: AppState, settings: Settings) -> None:
    """Use these settings from now on, and have them saved for the next start."""
    state.window.wishes += (KeepSettings(state.places.settings_file, settings, state.saved_settings),)
    state.settings = state.saved_settings = settings


def take_settings(state: AppState, request: KeepSettings, kept: Settings) -> None:
    """They are on disk. That another window remembers no paths is for this one, too, unless it has asked for
    more since."""
    is_newest = request.settings is state.saved_settings
    if is_newest and request.settings.remember_recent and not kept.remember_recent:
        state.settings = state.settings.remembering(False)
        state.saved_settings = state.saved_settings.remembering(False)
        say(state, "another window has switched off the list of recent files: it is empty here, too")


# ---- clip and time


def choose_path(
    state: AppState,
    kind: Kind,
    take: Callable[[AppState, Path], object] = lambda state, path: None,
    purpose: Purpose | None = None,
    name: str = "",
) -> None:
    """Let a person choose a folder or a file for `take`; `name` is proposed for a file to be written.

    Where that was is remembered for its purpose, which for some folders is all.
    """
    wanted = purpose or ("folder" if kind == "folder" else "file")
    start = state.folder_of(wanted) or _first_folder(state, wanted)
    state.window.choosing = Choosing(kind, partial(take, state), wanted, start, name)


def visit(state: AppState, folder: Path, *purposes: Purpose) -> None:
    """A person was there last for these purposes of a dialog; settings remember it where they may."""
    state.window.folders = {**state.window.folders, **dict.fromkeys(purposes, folder)}
    settings = state.settings
    for purpose in purposes:
        settings = settings.visited(purpose, folder)
    use_settings(state, settings)


def _first_folder(state: AppState, purpose: Purpose) -> Path:
    """Where a dialog begins that was never open."""
    if purpose == "run":
        return state.places.runs
    if purpose in ("export", "results", "session", "picture"):
        return state.places.pictures
    beside = state.source.path.parent if purpose == "calibration" and state.source.path else None
    return beside or state.folder_of("file") or state.folder_of("folder") or Path.home()


def taken_choice(state: AppState) -> Choosing | None:
    """What a dialog is to ask for, returned once; None for nothing."""
    choosing, state.window.choosing = state.window.choosing, None
    return choosing


def open_phantom(state: AppState) -> None:
    open_path(state, phantom_path())


def open_path(state: AppState, path: Path) -> None:
    """Ask for a clip or a run; what is open stays until the new one is there, what is unsaved for good."""
    path = path.parent if path.name == RunFolder(path.parent).record_path.name else path
    if path.suffix.lower() not in VIEW_SUFFIXES:
        open_request(state, _request_of(state, path))
    elif state.source.opening is not None:
        fail(state, f"{path.name} joins what is open: wait until {state.source.opening.path.name} is there")
    else:
        _begin_opening(state, _request_of(state, path))  # It ends no edits.


def open_first(state: AppState, paths: Sequence[Path]) -> None:
    """Of what was dropped on the window or given to it together: one case is open at a time."""
    first, *others = paths
    open_path(state, first)
    if others:
        said = f"of {len(paths)} items only {first.name} opens; a folder of images opens as one clip"
        announce(state, said)


def open_run(state: AppState, path: Path) -> None:
    """Ask for a run of the clip that is open: the session goes on with it, so nothing is asked about that."""
    go = partial(_begin_opening, state, _request_of(state, path))
    leave(state, partial(_leave_masks, state, go))


def open_request(state: AppState, request: OpenRequest) -> None:
    """Open this in the clip's place, after what is unsaved."""
    leave_clip(state, partial(_begin_opening, state, request))


def _request_of(state: AppState, path: Path) -> OpenRequest:
    path, clip = path.absolute(), state.source.clip
    beside = clip.path if clip is not None else None
    return OpenRequest(path, state.source.first_options(path), beside=beside)


def _begin_opening(state: AppState, request: OpenRequest) -> None:
    state.source.opening, state.window.banner = request, None
    state.live.choice.shown = False  # It would lie over what comes.
    state.live.stop_connecting()


def stop_opening(state: AppState) -> None:
    """Wait no longer for what is being opened: its answer, should one come, is of no use."""
    for request in filter(None, (state.source.opening, state.scene.second.opening)):
        say(state, f"stopped waiting for {request.path}")
    state.source.opening = state.scene.second.opening = state.window.banner = None
    state.live.stop_connecting()


def leave(state: AppState, go: Callable[[], None]) -> None:
    """Go on with what ends the edits of a model, after a question where they are not saved."""
    if state.editing.is_unsaved:
        state.editing.leaving = go
    else:
        go()


def leave_session(state: AppState, go: Callable[[], None]) -> None:
    """The same with what ends the session: after its edits, what has changed since it was saved."""

    def on() -> None:
        if state.session.is_unsaved:
            state.session.leaving = go
        else:
            go()

    leave(state, on)


def leave_clip(state: AppState, go: Callable[[], None]) -> None:
    """The same with what takes the clip's place: at last, masks of its tools that are not all there yet."""
    leave_session(state, partial(_leave_masks, state, go))


def _leave_masks(state: AppState, go: Callable[[], None]) -> None:
    if state.masking.making is not None:
        state.masking.leaving = go
    else:
        go()


def choose_chart(state: AppState, place: int) -> None:
    """Show this diagram of the report."""
    state.reports.place = place


def seek(state: AppState, index: int) -> None:
    """Go to a frame, kept within the clip, or to a moment of a reconstruction without one."""
    if state.is_model_alone:
        state.scene.own_time = min(max(index, 0), state.moments - 1) / state.moments
        state.timeline.playhead = float(state.moment)
    elif state.source.clip is not None:
        state.timeline.frame_index = min(max(index, 0), len(state.source.clip) - 1)
        state.timeline.playhead = float(state.timeline.frame_index)


def step(state: AppState, frames: int) -> None:
    """So many frames on or back, standing still; thaws a frozen picture, which would not show it. A single
    image gives way to one so many on or back in its folder."""
    if state.source.place is not None:
        _open_beside(state, state.source.neighbours.onward(state.source.path, frames))
        return
    state.timeline.playing, state.timeline.frozen_index = False, None
    seek(state, state.moment + frames)


def _open_beside(state: AppState, images: tuple[Path, ...]) -> None:
    """The first of these of the folder that can be read; nothing for none, or while one is on its way."""
    if images and state.source.opening is None:
        first, *onward = images
        open_request(state, OpenRequest(first, state.source.first_options(first), tuple(onward)))


def go_to_end(state: AppState, *, last: bool) -> None:
    """The first or the last frame that counts, or image of the folder, in the same way."""
    if state.source.place is not None:
        _open_beside(state, state.source.neighbours.from_end(state.source.path, last=last))
        return
    ends = (0, state.moments - 1) if state.is_model_alone else state.source.span
    step(state, ends[last] - state.moment)


def toggle_play(state: AppState) -> None:
    """A frame that could not be read is tried again, as once its drive is back."""
    if state.moments > 1:
        state.picture.failed = None
        state.timeline.playing = not state.timeline.playing
        state.timeline.playhead = float(state.moment)


def toggle_freeze(state: AppState) -> None:
    """Hold the pictures' frame, or let them follow the time again."""
    time = state.timeline
    if state.source.clip is not None:
        time.frozen_index = time.frame_index if time.frozen_index is None else None


def seek_view(state: AppState, time: float) -> None:
    """Time of the 3D view; moves the clip's frame when they are linked."""
    if state.follows_clip:
        first, count = state.timed
        seek(state, first + min(round(time * count), count - 1))
    else:
        state.scene.own_time = min(max(time, 0.0), 1.0)


def toggle_link(state: AppState) -> None:
    """Unlinked, the 3D view stays at the time it shows."""
    state.scene.own_time = state.time
    state.scene.linked = not state.scene.linked
