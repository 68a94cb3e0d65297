"""What is wished for only once the hand rests, so that no slider waits for it."""

from __future__ import annotations

from app.enhancement.frame_enhancer import Pictures
from app.gui.state.app_state import AppState
from app.gui.work.presets import BUILT_IN
from app.gui.work.strip import LeftOutRequest, StripRequest
from app.gui.work.thumbnails import ThumbnailsRequest
from app.gui.work.tidying import OnScreen

REST = 0.25
"""Seconds without a new picture before what can wait is done: measuring, small pictures, tidying."""


def at_rest(state: AppState) -> bool:
    """Whether no new picture has been asked for lately."""
    return not state.timeline.playing and state.window.now - state.picture.asked_at >= REST


def to_measure(state: AppState) -> Pictures | None:
    """The pictures on screen, once both are there."""
    pictures = state.picture.pictures
    if pictures is None or pictures.enhanced is None or not at_rest(state) or state.pictures_are_stale:
        return None
    return pictures


def thumbnails_wish(state: AppState) -> ThumbnailsRequest | None:
    """What each preset makes of the frame on screen, while the menu of presets is open."""
    pictures = state.picture.pictures
    if pictures is None or not state.enhancement.choosing or state.pictures_are_stale:
        return None
    return ThumbnailsRequest(pictures, tuple({**BUILT_IN, **state.enhancement.presets}.items()))


def strip_wish(state: AppState) -> StripRequest | None:
    """The small images of the clip, once its pictures are there."""
    clip, count = state.source.clip, state.timeline.strip_count
    if clip is None or state.picture.pictures is None or not at_rest(state) or count < 1:
        return None
    return StripRequest(clip, count)


def left_out_wish(state: AppState) -> LeftOutRequest | None:
    """At once: a person has asked for the tint."""
    clip = state.source.clip
    if clip is None or state.picture.pictures is None or not state.picture.overlay:
        return None
    return LeftOutRequest(clip, state.timeline.shown_index, state.source.part.mask)


def to_tidy(state: AppState) -> OnScreen | None:
    """Memory that what was open before had needed: given back once for everything that is opened."""
    if not at_rest(state) or state.pictures_wait or state.source.opening is not None:
        return None
    return OnScreen(state.source.path, state.source.clip)
