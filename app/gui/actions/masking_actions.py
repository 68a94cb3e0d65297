"""Tool masks mended by hand, as functions on the state."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from app.gui.actions import actions, clip_actions
from app.gui.state.app_state import AppState
from app.gui.state.masking import MOST_PAST, THICKEST, THINNEST, MaskStep
from app.gui.work.background import Failure
from app.gui.work.masking import (
    BY_HAND,
    FrameMask,
    GrowRequest,
    KeepMask,
    MakingRequest,
    MaskRequest,
    MasksRequest,
    MasksThere,
)
from app.gui.work.revealing import RevealRequest
from app.runs.making_masks import MaskReport
from app.runs.tool_masks import ToolMasks
from renderer.clip import BoolImage
from renderer.tools.brush import Point, Stroke, drawn
from renderer.tools.onnx_model import Values

STEP = 1.25
"""By which the brush grows and shrinks."""


def toggle(state: AppState) -> None:
    """Begin to mask tools, or end it."""
    masking = state.masking
    masking.active = not masking.active and not clip_actions.why_no_clip(state)
    # Masks are painted on the images, which may be behind another panel.
    state.source.asked |= masking.active
    drop_stroke(state)
    if masking.active and state.timeline.playing:
        actions.toggle_play(state)


def choose_tool(state: AppState, tool: Stroke) -> None:
    state.masking.tool = tool


def choose_radius(state: AppState, radius: float) -> None:
    """Of the brush, as a share of the frame's width."""
    state.masking.radius = min(max(radius, THINNEST), THICKEST)


def scale_radius(state: AppState, steps: float) -> None:
    choose_radius(state, state.masking.radius * STEP**steps)


def radius_in(state: AppState, width: int) -> float:
    """In pixels of a frame so many pixels wide."""
    return state.masking.radius * width


def mask_wish(state: AppState) -> MaskRequest | None:
    """The mask of the frame on screen, while it is not there; one that is being written comes later."""
    clip, masking = state.masks_clip, state.masking
    if clip is None or not masking.active or state.timeline.playing or state.picture.pictures is None:
        return None
    request = MaskRequest(clip, state.masks_folder, state.timeline.shown_index)
    if masking.shown is not None and masking.shown.request == request:
        return None
    return None if any(one.request == request for one in masking.keeping) else request


def there_wish(state: AppState) -> MasksRequest | None:
    """Which masks there are of the clip, once its pictures are there."""
    clip = state.masks_clip
    if clip is None or state.masking.there is not None or state.picture.pictures is None:
        return None
    return MasksRequest(clip, state.masks_folder)


def take_there(state: AppState, request: MasksRequest, there: MasksThere) -> None:
    """Of a clip that is no longer open, it is dropped."""
    if request.clip is state.masks_clip:
        _know(state, there)


def _know(state: AppState, there: MasksThere) -> None:
    state.masking.there = there
    state.masking.changes += 1
    state.source.tool_masks = ToolMasks(folder=str(state.masks_folder)) if there.origins else None


def take_mask(state: AppState, request: MaskRequest, frame: FrameMask) -> None:
    if request == mask_wish(state):
        _finish_line(state)
        state.masking.shown = frame


def paint(state: AppState, at: Point) -> None:
    """The stroke goes on to here, or begins; it ends with the frame that the hand went down on."""
    masking, index = state.masking, state.timeline.shown_index
    frame = masking.shown
    masking.hand_on = index if masking.hand_on is None else masking.hand_on
    if masking.hand_on != index:
        _finish_line(state)
        return
    if frame is None or frame.request.index != index or masking.growing is not None:
        return
    if masking.line and masking.line[-1] == at:
        return
    if not masking.line:
        _remember(state, frame)
    segment = (*masking.line[-1:], at)
    radius = radius_in(state, frame.mask.shape[1])
    mask = drawn(frame.mask, segment, radius, value=masking.tool != "erase")
    masking.line, masking.shown = (*masking.line, at), replace(frame, mask=mask)


def end_stroke(state: AppState) -> None:
    """The hand has let go: what was drawn is kept, or grows first."""
    state.masking.hand_on = None
    _finish_line(state)


def _finish_line(state: AppState) -> None:
    masking = state.masking
    line, masking.line, frame = masking.line, (), masking.shown
    if not line or frame is None:
        return
    if masking.tool == "grow":
        before, masking.past = masking.past[-1].taken(frame), masking.past[:-1]
        masking.growing = GrowRequest(before, line, radius_in(state, frame.mask.shape[1]))
    else:
        _set(state, frame.mask)


def drop_stroke(state: AppState) -> None:
    """The mask is as it was before the stroke under way."""
    masking = state.masking
    if masking.line and masking.shown is not None:
        masking.shown, masking.past = masking.past[-1].taken(masking.shown), masking.past[:-1]
    masking.line, masking.hand_on = (), None


def take_grown(state: AppState, request: GrowRequest, answer: BoolImage | Failure) -> None:
    """Of a frame that is no longer shown, it is dropped."""
    masking = state.masking
    if request is not masking.growing:
        return
    masking.growing = None
    is_shown = masking.shown is not None and masking.shown.request == request.frame.request
    masking.shown = request.frame if is_shown else masking.shown
    if isinstance(answer, Failure):
        actions.fail(state, f"the area cannot be grown: {answer.message}")
    elif is_shown:
        _remember(state, request.frame)
        _set(state, answer)


def undo(state: AppState) -> None:
    """The last stroke on this frame: it is as it was, and by whom it was masked. Nothing during a stroke."""
    masking, before = state.masking, state.masking.before
    if before is not None and masking.shown is not None and _is_at_rest(state):
        masking.past = _without(masking.past, before)
        masking.future = (*masking.future, MaskStep.of(masking.shown))[-MOST_PAST:]
        _return_to(state, before.taken(masking.shown))


def redo(state: AppState) -> None:
    """The stroke that was undone last on this frame, unless the mask was changed since; none during one."""
    masking, after = state.masking, state.masking.after
    if after is not None and masking.shown is not None and _is_at_rest(state):
        masking.future = _without(masking.future, after)
        _remember(state, masking.shown)
        _return_to(state, after.taken(masking.shown))


def _is_at_rest(state: AppState) -> bool:
    """No stroke is under way, and none grows."""
    return state.masking.growing is None and not state.masking.line


def _return_to(state: AppState, frame: FrameMask) -> None:
    state.masking.shown = frame
    mask = None if frame.origin is None else frame.mask
    _keep(state, KeepMask(frame.request, mask, frame.origin or BY_HAND))


def _remember(state: AppState, frame: FrameMask) -> None:
    """As it is before a stroke."""
    state.masking.past = (*state.masking.past, MaskStep.of(frame))[-MOST_PAST:]


def _without(steps: tuple[MaskStep, ...], gone: MaskStep) -> tuple[MaskStep, ...]:
    return tuple(step for step in steps if step is not gone)


def _of_others(steps: tuple[MaskStep, ...], request: MaskRequest) -> tuple[MaskStep, ...]:
    return tuple(step for step in steps if step.request != request)


def clear_frame(state: AppState) -> None:
    """State by hand that no tool is in this frame."""
    _finish_line(state)
    masking = state.masking
    if masking.shown is not None:
        _remember(state, masking.shown)
        _set(state, masking.shown.mask & False)


def accept(state: AppState) -> None:
    """Accept the mask as it is: it counts as drawn by hand."""
    _finish_line(state)
    if state.masking.shown is not None:
        _set(state, state.masking.shown.mask)


def forget_frame(state: AppState) -> None:
    """Forget the mask that was drawn by hand on this frame."""
    _finish_line(state)
    masking = state.masking
    if masking.shown is not None:
        request = masking.shown.request
        _keep(state, KeepMask(request, None))
        masking.shown = None
        masking.past, masking.future = (_of_others(each, request) for each in (masking.past, masking.future))


def _set(state: AppState, mask: BoolImage) -> None:
    """The mask of the frame on screen, by hand."""
    masking = state.masking
    assert masking.shown is not None
    masking.shown = replace(masking.shown, mask=mask, origin=BY_HAND)
    masking.future = _of_others(masking.future, masking.shown.request)
    _keep(state, KeepMask(masking.shown.request, mask))


def _keep(state: AppState, wanted: KeepMask) -> None:
    state.masking.keeping = (*state.masking.keeping, wanted)
    state.window.wishes += (wanted,)


def take_kept(state: AppState, request: KeepMask, answer: KeepMask | Failure) -> None:
    masking = state.masking
    masking.keeping = tuple(one for one in masking.keeping if one is not request)
    if isinstance(answer, Failure):
        actions.fail(state, f"the tool mask cannot be saved: {answer.placed}")
    elif masking.there is not None and masking.there.request.clip is request.request.clip:
        origin = None if request.mask is None else request.origin
        _know(state, masking.there.with_mask(request.request.index, origin))


def make_all(state: AppState, source: Path | None = None) -> None:
    """Mask all frames that are not masked by hand, by what `MakingRequest` says of the source."""
    clip = state.masks_clip
    masking = state.masking
    if clip is None or masking.making is not None:
        return
    values, tools = masking.network_values, network_tools(state) or ()
    masking.making = MakingRequest(clip, state.masks_folder, source, values, tools)
    masking.report = None


def network_tools(state: AppState) -> tuple[int, ...] | None:
    """The classes of a network that are tools, empty: all but the first; None: what is typed are none."""
    words = state.masking.network_tools.replace(",", " ").split()
    return tuple(map(int, words)) if all(word.isdecimal() and len(word) < 6 for word in words) else None


def choose_network_values(state: AppState, values: Values) -> None:
    """Choose the values that the network takes."""
    state.masking.network_values = values


def type_network_tools(state: AppState, text: str) -> None:
    """Classes of a network, apart by spaces or commas."""
    state.masking.network_tools = text


def choose_folder(state: AppState) -> None:
    """Take masks that lie in another folder."""
    actions.choose_path(state, "folder", make_all, "masks")


def choose_network(state: AppState) -> None:
    """Choose the file of a network, which then finds the tools in all frames."""
    actions.choose_path(state, "file", make_all, "network")


def stop_making(state: AppState) -> None:
    """What is made so far stays, and is looked at anew."""
    _finish_line(state)
    masking = state.masking
    masking.making = masking.there = masking.shown = None
    masking.past = masking.future = ()


def answer(state: AppState, *, agreed: bool) -> None:
    """To whether something else may be opened while masks are not all there."""
    go, state.masking.leaving = state.masking.leaving, None
    if agreed and go is not None:
        go()


def tell_interrupted(state: AppState, making: MakingRequest | None) -> None:
    """That were being made until something else was opened, in place of the clip that they are of."""
    if making is None or state.masking.making is making:
        return
    actions.announce(state, f"tool masks of {making.clip.name} were interrupted: those made so far stay")


def take_made(state: AppState, request: MakingRequest, answer: MaskReport | Failure) -> None:
    masking = state.masking
    if request is not masking.making:
        return
    if isinstance(answer, Failure):
        actions.fail(state, f"the tools cannot be masked: {answer.message}")
        stop_making(state)
        return
    masking.report = answer
    if answer.done == len(request.clip):
        stop_making(state)


def reveal(state: AppState) -> None:
    """The folder of the masks in the system's file manager."""
    state.window.wishes += (RevealRequest(state.masks_folder),)
