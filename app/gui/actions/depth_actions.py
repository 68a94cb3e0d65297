"""Where the depth of the open clip comes from, as functions on the state. No ImGui."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final

from pydantic import ValidationError

from app.console.flags import problem
from app.enhancement.clip_statistics import ClipStatistics
from app.files.legible import capital, legible
from app.gui.actions import actions, clip_actions
from app.gui.state.app_state import AppState
from app.gui.work.background import Failure
from app.gui.work.depths import DepthRequest, WaysRequest
from app.gui.work.opening import read_as
from app.scenes.view_kinds import SCENE_UNITS
from renderer.clip import Clip, DepthOrigin
from renderer.depth.depth_ways import DEPTH_WAYS, DepthWay, DepthWays, way_of
from renderer.readers.clip_options import DEFAULTS, ClipOptions, DepthSource
from renderer.readers.image_folders.frames import is_seen_by_assumption

BY: Final[Mapping[DepthOrigin, str]] = {
    "measured": "Depth in units of its own",
    "beside": "Maps of unknown units",
    "stereo": "Stereo with an unknown baseline",
    "monocular": "Guessed, from the maps beside the images",
    "brightness": "Guessed, from brightness",
    "motion": "From the camera's motion",
}
MOVES_OR_NOT: Final = (
    "From motion if the endoscope moves; Guessed if it is held still. Neither has a scale in mm."
)
READING: Final = "Reading the clip with this depth…"
LOOKING: Final = "Looking at what this clip offers…"


def chosen_way(state: AppState) -> DepthWay | None:
    """That of the open clip, or of the one that takes its place in a moment; None without any depth."""
    clip, wish, ways = state.source.clip, state.source.depth_wish, state.source.depth_ways
    if wish is not None and ways is not None:
        return next((way for way in DEPTH_WAYS if ways.source(way) == wish.options.depth), None)
    return way_of(clip) if clip is not None else None


def why_not(state: AppState, way: DepthWay) -> str:
    """Why the clip cannot be read in this way, in a sentence; empty when it can."""
    ways = state.source.depth_ways
    return LOOKING if ways is None else ways.why_not[way]


def said(state: AppState) -> str:
    """What a person should know of the depth of the open clip, in a line; empty where nothing."""
    return READING if state.source.depth_wish is not None else why_no_depth(state) or without_scale(state)


def why_no_depth(state: AppState) -> str:
    """What a reconstruction of the open clip has to start from is still to be chosen; empty: it is there."""
    clip = state.source.clip
    if clip is None or clip.has_depth or clip.points is not None or clip.depth_origin == "motion":
        return ""
    if not clip.has_one_size:
        return f"{capital(clip.why_no_depth)}."
    # What is open needs no path.
    known = legible(clip.why_no_depth.removesuffix(f": {clip.path}"))
    why = f"{capital(known)}." if known else "This clip has no depth."
    if why_not(state, "motion"):
        return f"{why} Guessed: no scale, so no distances in mm."
    return f"{why} {MOVES_OR_NOT}"


def without_scale(state: AppState) -> str:
    """What that means, in a line, where lengths of the open clip have no scale; empty where they have."""
    clip = state.source.clip
    if clip is None or way_of(clip) is None or clip.unit != SCENE_UNITS:
        return ""
    return f"{BY[clip.depth_origin]}: no scale, so no distances in mm."


def choose_way(state: AppState, way: DepthWay) -> None:
    """From now on; what is trained keeps what it was started with."""
    ways = state.source.depth_ways
    if ways is not None and way != chosen_way(state) and not ways.why_not[way]:
        choose_source(state, ways.source(way))


def choose_source(state: AppState, source: DepthSource) -> None:
    """The same, as the option of the command line says it."""
    choose_reading(state, replace(state.source.reading, depth=source))


def assumes_view(state: AppState) -> bool:
    """The field of view of the open clip is assumed where nobody types it."""
    return state.source.bare is not None and is_seen_by_assumption(state.source.bare)


def type_baseline(state: AppState, text: str) -> None:
    """In mm, as typed; empty: that of the clip, or unknown."""
    _type(state, "baseline", text)


def type_field_of_view(state: AppState, text: str) -> None:
    """In degrees, as typed; empty: the one that is assumed."""
    _type(state, "field_of_view", text)


def _type(state: AppState, name: str, text: str) -> None:
    """A number of the options, with its unit or without; what is none, or out of its range, is refused in a
    sentence."""
    plain = re.sub(r"\s*(mm|°)?\s*$", "", text).strip().replace(",", ".")
    try:
        values: dict[str, Any] = {name: float(plain) if plain else getattr(DEFAULTS, name)}
        options = replace(state.source.reading, **values)
    except ValidationError as error:
        actions.fail(state, problem(error, {name: capital(name.replace("_", " "))}))
    except ValueError:
        actions.fail(state, f"{capital(name.replace('_', ' '))}: expected a number, got {plain}")
    else:
        choose_reading(state, options)


def choose_reading(state: AppState, options: ClipOptions) -> None:
    """How the open clip is read from now on."""
    if state.source.clip is not None and state.source.bare is not None:
        changed = options != state.source.options
        state.source.depth_wish = DepthRequest(state.source.bare, options) if changed else None
        clip_actions.keep_reading(state, options)


def take_ways(state: AppState, request: WaysRequest, answer: DepthWays) -> None:
    if request.bare is state.source.bare:
        state.source.depth_ways = answer


def take_depth(state: AppState, request: DepthRequest, answer: Clip | Failure) -> None:
    """The same frames take the place of those that are shown, with all that has been made of them."""
    if request is not state.source.depth_wish:
        return
    state.source.depth_wish = None
    if isinstance(answer, Failure):
        clip_actions.keep_reading(state, state.source.options)
        _forget_reading(state)
        actions.fail(state, f"the depth of the clip stays as it is: {answer.message}")
        return
    before, state.source.clip, state.source.options = state.source.clip, answer, request.options
    if before is not None:
        _carry_over(state, before, answer)
    known = () if before is None else before.notices
    shown = state.source.notices
    # What has been read before does not come back with the new depth.
    state.source.notices = tuple(each for each in read_as(answer) if each in shown or each not in known)
    for notice in answer.notices:
        if notice not in known:
            actions.say(state, notice)


def _forget_reading(state: AppState) -> None:
    """The newest step of undo does not lead to depth that cannot be read."""
    past, now = state.enhancement.past, state.source.options
    past[-1] = replace(past[-1], depth=now.depth, baseline=now.baseline, field_of_view=now.field_of_view)
    if past[-2:-1] == past[-1:]:
        past.pop()


def _carry_over(state: AppState, before: Clip, now: Clip) -> None:
    """What was made of images alone is of the new clip as well, so that what is on screen stays."""
    picture, strip = state.picture, state.timeline.strip
    if picture.pictures is not None and picture.pictures.request.clip is before:
        request, measured = replace(picture.pictures.request, clip=now), picture.measured
        of_shown = measured is not None and measured.pictures is picture.pictures
        picture.pictures = replace(picture.pictures, request=request)
        if measured is not None and of_shown:
            picture.measured = replace(measured, pictures=picture.pictures)
    if picture.of_clip is not None and picture.of_clip.request.clip is before:
        known = picture.of_clip
        picture.of_clip = ClipStatistics(replace(known.request, clip=now), known.statistics)
    if strip is not None and strip.request.clip is before:
        state.timeline.strip = replace(strip, request=replace(strip.request, clip=now))
