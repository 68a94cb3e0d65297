"""Follows the live source, once a frame: begins and ends it, shows its newest picture, tells its troubles."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from app.enhancement.frame_enhancer import PictureRequest, Pictures
from app.enhancement.methods import preset_of
from app.enhancement.settable import drawn
from app.files.legible import located
from app.gui.actions import actions, arriving, live_actions
from app.gui.state.app_state import AppState
from app.gui.state.live import Live
from app.gui.update.live_pace import wait_for_picture
from app.gui.work.opening import Opened
from app.live.picture import LivePicture, LiveSetting
from app.live.recorder import Recording
from app.live.session import LiveSession
from app.live.sources.opening import open_input
from app.live.sources.source import Source

MakeSession = Callable[[Callable[[], Source], LiveSetting], LiveSession]


def follow_live(state: AppState, make_session: MakeSession) -> None:
    _follow_recordings(state)
    if state.live.asked is not None:
        _begin(state, make_session)
    live = state.live
    if live.session is None:
        return
    if live.leaving or _gave_way(state):
        end_live(state)
        return
    _follow_sending(state)
    live.session.setting, live.session.recipients = _setting(state), live.recipients
    live.status = live.session.status()
    picture = live.session.pictures.take(wait_for_picture(live, time.perf_counter()))
    live.drawing.began = time.perf_counter()
    if picture is not None:
        live.newest = picture
    if live.still is None and live.newest is not None and not _is_shown(state, live.newest):
        _show(state, live.newest)
        live.unshown = picture or live.unshown
    _tell(state)


def shown(state: AppState) -> None:
    """The swap is done: what was drawn is on the screen."""
    live, now = state.live, time.perf_counter()
    if live.session is not None and live.unshown is not None:
        live.session.shown(live.unshown, now)
    live.unshown = None
    live.drawing.end(now)


def end_live(state: AppState) -> None:
    """Let go of the source, and let a recording be completed, waiting for neither. The last picture stays."""
    live = state.live
    session, recorder, completing = live.session, live.recorder, live.completing
    if session is not None:
        session.end()
    if recorder is not None:
        recorder.end()
        completing += (recorder,)
    if live.sender is not None:
        live.sender.end()
    if live.clip is not None and live.newest is not None and state.source.clip is live.clip:
        state.source.clip = live_actions.still_of(live.newest)
    state.live = Live(
        choice=live.choice, what=live.what, endpoint=live.endpoint, asked=live.asked, completing=completing
    )


def close_live(state: AppState) -> None:
    """The same at the end of the window, which waits: the process would take the recording with it."""
    session = state.live.session
    end_live(state)
    if session is not None:
        session.close()
    for recorder in state.live.completing:
        recorder.finish()


def _begin(state: AppState, make_session: MakeSession) -> None:
    """What is live until now gives way."""
    asked, send, state.live.asked = state.live.asked, state.live.send_asked, None
    end_live(state)
    assert asked is not None
    source, wish = asked
    state.live.source = source
    state.live.session = make_session(partial(open_input, source, wish), _setting(state))
    if send:
        live_actions.toggle_sending(state)


def _gave_way(state: AppState) -> bool:
    """Whether something else has been opened in place of the live source."""
    live = state.live
    return (
        live.clip is not None and state.source.clip is not live.clip and state.source.clip is not live.still
    )


def _setting(state: AppState) -> LiveSetting:
    """White light while its kernels are compiled."""
    params, pixels = state.enhancement.params, drawn(state.enhancement.pixels)
    off = not state.enhancement.active or state.lacks(preset_of(params))
    return LiveSetting(None if off else params, pixels)


def _is_shown(state: AppState, picture: LivePicture) -> bool:
    shown = state.picture.pictures
    return shown is not None and shown.original is picture.original


def _show(state: AppState, picture: LivePicture) -> None:
    live, size = state.live, (picture.original.shape[1], picture.original.shape[0])
    assert live.source is not None
    if live.clip is None:
        clip = live_actions.following(live.source, live, picture)
        arriving.show_opened(state, Path(live.source.name), Opened(clip=clip, in_passing=True))
        live.clip, state.source.path = clip, None
    elif (live.clip.size, live.clip.pixel_aspect) != (size, picture.pixel_aspect):
        actions.say(state, f"the live frames have another shape now: {size[0]} × {size[1]}")
        live.clip = state.source.clip = live_actions.following(live.source, live, picture)
        state.picture.view = replace(state.picture.view, pixel_aspect=live.clip.pixel_aspect)
    setting = picture.setting
    request = PictureRequest(live.clip, 0, setting.params, "image", setting.pixels)
    state.picture.pictures = Pictures(
        request,
        picture.original,
        picture.enhanced,
        picture.statistics,
        picture.milliseconds,
        picture.omitted,
    )


def _tell(state: AppState) -> None:
    """Trouble before the first picture, where nothing on screen says it; each once."""
    live, status = state.live, state.live.status
    if status is None or live.clip is not None or not status.reason or status.reason == live.told:
        return
    live.told = status.reason
    actions.fail(state, status.reason)
    if status.signal == "failed":
        live.leaving = True
    elif state.window.banner is not None:
        state.window.banner = replace(state.window.banner, can_stop=True)


def _follow_recordings(state: AppState) -> None:
    """Those that have ended, as they were told to or by themselves."""
    live = state.live
    if live.recording is not None and live.recording.is_over:
        _tell_recording(state, live.recording)
        live.recorder = None
    over = [one for one in live.completing if one.state.is_over]
    live.completing = tuple(one for one in live.completing if one not in over)
    for one in over:
        _tell_recording(state, one.state)


def _follow_sending(state: AppState) -> None:
    """Where it has ended by itself."""
    sending = state.live.sending
    if sending is not None and sending.is_over:
        state.live.sender = None
        actions.fail(state, f"sending to {sending.address} ended: {sending.trouble}")


def _tell_recording(state: AppState, done: Recording) -> None:
    if done.trouble:
        actions.fail(state, f"the recording ended: {done.trouble}. What was recorded until then is kept.")
    elif done.pictures:
        more = f" in {done.files} files" if done.files > 1 else ""
        actions.announce(state, f"recorded {done.path.name}{more} in {located(done.path.parent)}")
        state.exports.last = done.path
