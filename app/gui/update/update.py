"""Once a frame, before drawing: take what background work has finished, ask for what the state now needs."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import replace

from app.enhancement.frame_enhancer import Pictures
from app.gui.actions import actions, edit_actions, path_actions
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels
from app.gui.update.jobs import follow_job
from app.gui.update.wishes import side_wish
from app.gui.views.comparison import SIDES
from app.scenes.clip_speed import FRAMES_PER_SECOND
from renderer.clip import Clip

PROMPT = 0.012
"""Seconds that a frame waits for a picture after a setting has moved: most come in less, and are shown in the
frame that moved it."""
PATIENCE = 0.3
"""Seconds before a new frame is shown without its enhanced partner."""


def update(state: AppState, channels: Channels, now: float) -> None:
    """Advance to `now`, seconds on the window's clock."""
    elapsed, state.window.now = now - state.window.now, now
    _time_toast(state)
    for row in channels.rows:
        row.answer(state)
        # Another model may have come: what comes after is to be of that one.
        edit_actions.follow(state)
    take_pictures(state, channels)
    follow_job(state)
    _play(state, elapsed)
    path_actions.advance_path(state, elapsed)
    _ask(state, channels)


def _ask_for_pictures(state: AppState, channels: Channels) -> bool:
    """Before answers are taken, for a setting that has moved, and at the end, for a frame that plays. Whether
    these had not been asked for before."""
    pictures = state.asked_pictures
    if pictures != state.picture.failed:
        # What could not be read is tried again by whoever comes back to it.
        state.picture.failed = None
    if pictures is None or state.live.flows or pictures in (channels.pictures.asked, state.picture.failed):
        return False
    state.picture.asked_at = state.window.now
    channels.pictures.ask(pictures)
    return True


def take_pictures(state: AppState, channels: Channels) -> None:
    """Those of a setting that has just moved too, where they come soon: before a frame and within it."""
    if _ask_for_pictures(state, channels) and _may_come_at_once(state):
        channels.pictures.wait(PROMPT)
    taken = channels.pictures.take()
    if taken is not None and taken[0].clip is state.source.clip:
        request, answer = taken
        if isinstance(answer, Pictures):
            channels.original = answer
        elif request == state.asked_pictures:
            state.timeline.playing, state.picture.failed = False, request
            channels.pictures.want(None)
            actions.fail(state, answer.message)
    if channels.original is not None and _may_show(state, channels.original):
        state.picture.pictures, channels.original = channels.original, None


def _may_come_at_once(state: AppState) -> bool:
    """Another setting for the frame on screen, where the last one took little time."""
    shown, request = state.picture.pictures, state.asked_pictures
    if shown is None or shown.enhanced is None or request is None or shown.request == request:
        return False
    same = replace(shown.request, params=None) == replace(request, params=None)
    return same and request.params is not None and shown.milliseconds < 1000 * PROMPT


def _may_show(state: AppState, pictures: Pictures) -> bool:
    """An original and its enhanced partner appear together; alone only where it would be long in coming, and
    never in a clip that plays enhanced, which would flash."""
    if pictures.request.clip is not state.source.clip:
        return False
    if pictures.enhanced is not None or pictures.request.params is None or state.picture.pictures is None:
        return True
    same_frame = state.picture.pictures.request.frame_index == pictures.request.frame_index
    if state.timeline.playing and state.picture.pictures.enhanced is not None:
        return False
    return not same_frame and state.window.now - state.picture.asked_at > PATIENCE


LATELY = 1.5
"""Seconds that the pace of playing is of, about."""


def _time_toast(state: AppState) -> None:
    """It goes after its time, which begins when the questions of the start are answered: they lie over it."""
    toast, now = state.window.toast, state.window.now
    if toast is None:
        return
    if not state.settings.acknowledged or state.session.recoverable is not None:
        state.window.toast = replace(toast, until=now + actions.TOAST_SECONDS)
    elif now > toast.until:
        state.window.toast = None


def _play(state: AppState, elapsed: float) -> None:
    """Time goes on only when what it needs is on screen: a slow machine plays slower, never out of step."""
    if state.timeline.playing and state.is_model_alone:
        _play_alone(state, elapsed)
        return
    clip, span, time = state.source.clip, state.source.span, state.timeline
    if not time.playing or clip is None:
        time.pace = 1.0
        return
    waits = time.frozen_index is None and state.pictures_wait
    seconds = 0.0 if waits else min(elapsed, 0.25)
    if elapsed > 0:
        share = math.exp(-elapsed / LATELY)
        time.pace = share * time.pace + (1 - share) * seconds / elapsed
    if not waits:
        time.playhead = onward(clip, span, time.playhead, seconds)
        time.frame_index = int(time.playhead)


def _play_alone(state: AppState, elapsed: float) -> None:
    """A reconstruction without its clip, as fast as that goes; after the last moment comes the first."""
    time, model = state.timeline, state.scene.model
    speed = (model.frames_per_second if model is not None else None) or FRAMES_PER_SECOND
    time.playhead = (time.playhead + min(elapsed, 0.25) * speed) % state.moments
    state.scene.own_time = int(time.playhead) / state.moments


def _ask(state: AppState, channels: Channels) -> None:
    _ask_for_pictures(state, channels)
    # Known before others are asked for.
    state.comparing.waits = any(side_wish(state, side) is not None for side in SIDES)
    for row in channels.rows:
        row.ask(state)
    state.runs.is_listed = state.runs.sees_measures = state.tuning.in_sight = False
    channels.ask_once(state)


MOMENT = 1e-6
"""Seconds that a frame lasts at least, also beside another one of the same time."""


def onward(clip: Clip, span: tuple[int, int], playhead: float, seconds: float) -> float:
    """The playhead after so many seconds, in frames; each frame lasts as long as in the file, and after the
    last frame of the span comes its first."""
    first, last = span
    if not first <= playhead < last + 1:
        return float(first)
    frame = int(playhead)
    now = _time(clip, frame) + (playhead - frame) * _lasting(clip, frame) + seconds
    start = _time(clip, first)
    now = start + (now - start) % (_time(clip, last) + _lasting(clip, last) - start)
    frame = min(max(_frame_at(clip, now), first), last)
    return frame + min(max((now - _time(clip, frame)) / _lasting(clip, frame), 0.0), 1.0 - MOMENT)


def _rate(clip: Clip) -> float:
    return clip.frames_per_second or FRAMES_PER_SECOND


def _time(clip: Clip, frame: int) -> float:
    return clip.frame_times[frame] if clip.frame_times else frame / _rate(clip)


def _lasting(clip: Clip, frame: int) -> float:
    if not clip.frame_times or frame + 1 == len(clip):
        return 1 / _rate(clip)
    return max(clip.frame_times[frame + 1] - clip.frame_times[frame], MOMENT)


def _frame_at(clip: Clip, seconds: float) -> int:
    return bisect_right(clip.frame_times, seconds) - 1 if clip.frame_times else int(seconds * _rate(clip))
