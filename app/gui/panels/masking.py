"""Tool masks: what a drag over the frame draws, which frames are masked by hand, and masks of all others; the
brush over the frame."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Final

from imgui_bundle import ImVec2, imgui, imgui_ctx

from app.files.legible import capital
from app.gui.actions import actions, clip_actions, masking_actions
from app.gui.state.app_state import AppState
from app.gui.state.masking import THICKEST, THINNEST, Masking
from app.gui.style import theme
from app.gui.style.asking import ask
from app.gui.style.fields import number
from app.gui.style.widgets import (
    Area,
    beside,
    button,
    choose_row,
    em,
    explain,
    in_line,
    muted,
    note,
    percent,
    row,
    toggle,
)
from app.gui.views.picture_view import Placement
from app.gui.work.masking import BY_HAND, FROM_FOLDER, FrameMask
from app.runs.making_masks import MaskReport
from renderer.tools.brush import Stroke
from renderer.tools.onnx_model import Values

PANEL: Final = "Masks"
TOOL_TEXTS: Final[dict[Stroke, str]] = {
    "paint": "Drag over a tool to mask it. The right button moves the frame.",
    "erase": "Drag over tissue that is masked.",
    "grow": "Drag along the middle of a tool: the mask grows from there to the edges in the frame.",
}
SIZE_TEXT: Final = "Radius of the brush in pixels of the frame. [ and ] or Shift and the wheel change it."
MAKE_TEXT: Final = (
    "Masks the tools in every frame that is not masked by hand: learned from those that are, or by colour "
    "where there are none."
)
WHY: Final = "Masked tools are neither trained on nor evaluated."
ORIGINS: Final = {
    "by hand": "masked by hand",
    "from a folder": "from the masks of a folder",
    "learned": "learned from other frames",
    "by colour": "found by colour",
    "by a model": "found by a model",
    None: "found by colour",
}
ACCEPT_TEXT: Final = "Count this mask as masked by hand: other frames are learned from it."
FORGET_TEXT: Final = "Discard the mask of this frame, which then counts as not masked yet."
IOU_TEXT: Final = (
    "Overlap (IoU) of learned masks with masks by hand, on frames left out of the learning in turn: "
    "1 is perfect."
)
NEIGHBOURS_TEXT: Final = (
    "Overlap (IoU) of each mask with that of the frame before, moved along by optical flow, on average."
)
FOLDER_TEXT: Final = (
    "Import masks from another program: images named or numbered like the frames; all that is not black is "
    "tool. Masks by hand stay."
)
NETWORK_TEXT: Final = (
    "Your own ONNX file finds the tools in frames that are not masked by hand. Its input, and which of its "
    "classes are tools, are set below."
)
VALUES_TEXT: Final = "Pixel values that the network takes, red first."
VALUE_NAMES: Final[dict[Values, str]] = {
    "imagenet": "ImageNet's mean and spread",
    "unit": "0 to 1",
    "bytes": "0 to 255",
}
CLASSES_TEXT: Final = "Numbers of the classes that are tools, from 0. Empty: all but the first."
NO_CLASSES: Final = "Classes are whole numbers from 0, such as 1 3."
NONE_YET: Final = "None by hand yet: mask two or three first."
MOST_LISTED: Final = 6


def draw_masking_question(state: AppState) -> None:
    """Before something else takes the place of a clip whose tools are still being masked."""
    if state.masking.leaving is None:
        return
    said, ended = ("Tools are still being masked. Masks made so far stay.",), state.masking.making is None
    if reply := ask("Interrupt masking?", said, ("Interrupt", "Stay"), moot=ended):
        masking_actions.answer(state, agreed=ended or reply == "Interrupt")


def draw_masking(state: AppState) -> None:
    if reason := clip_actions.why_no_clip(state):
        muted(reason)
        return
    _draw_tools(state)
    _draw_frame(state)
    imgui.separator_text("All frames")
    _draw_by_hand(state)
    _draw_making(state)
    imgui.spacing()
    ends = (
        (
            "Show in folder",
            masking_actions.reveal,
            "The masks as images: white is tool.",
            _has_any(state.masking),
        ),
        ("Done", masking_actions.toggle, "Esc: stop masking. Masks stay with the clip.", True),
    )
    for (label, act, text, enabled), width in in_line(ends):
        button(f"{label}###masks {label}", partial(act, state), text, enabled=enabled, width=width)


def _has_any(masking: Masking) -> bool:
    return masking.there is not None and bool(masking.there.origins)


def _draw_tools(state: AppState) -> None:
    masking = state.masking
    for (tool, text), width in in_line(tuple(TOOL_TEXTS.items()), 0.25):
        choose = partial(masking_actions.choose_tool, state, tool)
        toggle(f"{capital(tool)}###mask {tool}", choose, text, on=tool == masking.tool, width=width)
    across = masking.shown.mask.shape[1] if masking.shown is not None else 0
    row("Brush", SIZE_TEXT, -4.0)
    flags = imgui.SliderFlags_.logarithmic | imgui.SliderFlags_.always_clamp
    imgui.begin_disabled(across == 0)
    low, high = (share * max(across, 1) for share in (THINNEST, THICKEST))
    with imgui_ctx.push_style_color(imgui.Col_.text, theme.CLEAR):
        changed, radius = imgui.slider_float("##brush", masking.radius * across, low, high, "%.0f", flags)
    imgui.end_disabled()
    explain(SIZE_TEXT)
    imgui.same_line()
    number(f"{masking.radius * across:.0f} px")
    if changed:
        masking_actions.choose_radius(state, radius / across)


def _draw_frame(state: AppState) -> None:
    """What the mask of this frame is, and what can be done with it as a whole."""
    masking, shown = state.masking, state.masking.shown
    if shown is None:
        muted("Looking for tools in this frame…")
    else:
        note(_said(shown), theme.now().text)
        explain(WHY)
    by_hand = shown is not None and shown.origin == BY_HAND
    busy = "The area is growing." if masking.growing is not None else ""
    controls = (
        (
            "Undo",
            masking_actions.undo,
            "Undo the last stroke on this frame. Ctrl+Y redoes it.",
            masking.before is not None,
        ),
        ("Clear", masking_actions.clear_frame, "Mark this frame as free of tools.", shown is not None),
        ("Accept", masking_actions.accept, ACCEPT_TEXT, shown is not None and not by_hand),
        ("Drop", masking_actions.forget_frame, FORGET_TEXT, shown is not None and shown.origin is not None),
    )
    for (label, act, text, enabled), width in in_line(controls, 0.25):
        button(
            f"{label}###mask {label}", partial(act, state), text, enabled=enabled, reason=busy, width=width
        )


def _said(shown: FrameMask) -> str:
    share = f"{_part(shown.mask.mean())} of this frame" if shown.mask.any() else "no tool in this frame"
    if shown.origin is None and shown.own.any():
        return f"{_part(shown.own.mean())} masked by the clip's own masks, which stay"
    return f"{capital(ORIGINS[shown.origin])}: {share}"


def _part(share: float) -> str:
    """A share in words; one that is not 0 is never shown as 0 %."""
    return "less than 1 %" if 0 < share < 0.01 else percent(share)


def _draw_by_hand(state: AppState) -> None:
    there = state.masking.there
    frames = () if there is None else there.frames(BY_HAND)
    if not frames:
        given = 0 if there is None else len(there.frames(FROM_FOLDER))
        note(f"{given} from a folder, which teach the others." if given else NONE_YET)
        explain(MAKE_TEXT)
        return
    muted("By hand")
    imgui.same_line(0, em(0.5))
    _draw_frames(state, "by hand", frames)


def _draw_frames(state: AppState, name: str, frames: Sequence[int]) -> None:
    """Frames to go to, in a line as long as there is room."""
    for place, index in enumerate(frames):
        label = str(index + 1)
        if place:
            beside(label, 0.25)
        go = partial(actions.seek, state, index)
        button(f"{label}###{name} {index}", go, "Go to this frame.", small=True)


def _draw_making(state: AppState) -> None:
    masking, report, count = state.masking, state.masking.report, state.moments
    if masking.making is not None:
        done = 0 if report is None else report.done
        said = f"{done} of {count}" if done else "learning…"
        imgui.progress_bar(done / max(count, 1), ImVec2(-1, em(1.25)), said)
        button(
            "Stop###stop masks",
            partial(masking_actions.stop_making, state),
            "Masks made so far stay.",
            width=-1,
        )
        return
    make = partial(masking_actions.make_all, state)
    waits = "A mask is being saved." if masking.keeping else ""
    button(
        "Mask all other frames###make masks", make, MAKE_TEXT, reason=waits, color=theme.now().lit, width=-1
    )
    wrong = NO_CLASSES if masking_actions.network_tools(state) is None else ""
    others = (
        ("From a folder…", masking_actions.choose_folder, FOLDER_TEXT, waits),
        ("By a network…", masking_actions.choose_network, NETWORK_TEXT, waits or wrong),
    )
    for (label, act, text, reason), width in in_line(others):
        button(f"{label}###masks {label}", partial(act, state), text, reason=reason, width=width)
    _draw_network(state, wrong)
    if report is not None and report.done:
        _draw_report(state, report)


def _draw_report(state: AppState, report: MaskReport) -> None:
    note(f"Tools in {report.with_tools} of {report.done} frames, {_part(report.share)} of the pixels")
    if report.held_out is not None:
        note(f"Overlap with masks by hand: {report.held_out:.2f}")
        explain(IOU_TEXT)
    if report.agreement is not None:
        note(f"Overlap between neighbours: {report.agreement:.2f}")
        explain(NEIGHBOURS_TEXT)
    for notice in report.notices:
        note(notice)
    if report.weak:
        imgui.text_colored(theme.now().warning, "Look at")
        imgui.same_line(0, em(0.5))
        _draw_frames(state, "weak", report.weak[:MOST_LISTED])


def _draw_network(state: AppState, wrong: str) -> None:
    """What the network of a user takes and gives."""
    if not imgui.tree_node("Network settings###network"):
        return
    masking = state.masking
    values = choose_row("Pixel values", masking.network_values, VALUE_NAMES, VALUES_TEXT)
    masking_actions.choose_network_values(state, values)
    row("Tool classes", CLASSES_TEXT)
    changed, text = imgui.input_text_with_hint("##classes", "all but the first", masking.network_tools)
    explain(CLASSES_TEXT)
    if changed:
        masking_actions.type_network_tools(state, text)
    if wrong:
        imgui.text_colored(theme.now().warning, wrong)
    imgui.tree_pop()


def follow_brush(state: AppState, place: Placement, area: Area) -> None:
    """The mouse on the pane that was drawn last: a drag with the left button draws."""
    at = place.picture_at(*area.mouse())
    if imgui.is_item_active() and imgui.is_mouse_down(imgui.MouseButton_.left):
        masking_actions.paint(state, at)
    elif not imgui.is_mouse_down(imgui.MouseButton_.left):
        # Escape takes the mouse from the pane while the button is still held: it drops the stroke.
        masking_actions.end_stroke(state)


def size_by_wheel(state: AppState) -> bool:
    """Whether it did, over the pane, which is the item before, while Shift is held."""
    io = imgui.get_io()
    if not (state.masking.active and io.key_shift):
        return False
    imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
    # macOS turns the wheel's axis with Shift.
    masking_actions.scale_radius(state, io.mouse_wheel or io.mouse_wheel_h)
    return True


def draw_brush(state: AppState, place: Placement, area: Area) -> None:
    """What it covers, at the pointer."""
    shown = state.masking.shown
    if shown is None or not imgui.is_item_hovered():
        return
    pixels = masking_actions.radius_in(state, shown.mask.shape[1])
    radius = ImVec2(max(pixels * place.zoom_x, 1.0), max(pixels * place.zoom, 1.0))
    draw, at = imgui.get_window_draw_list(), area.corner + area.mouse()
    for color, weight in ((theme.grey(0.0, 0.8), 3.0), (theme.grey(1.0), 1.0)):
        draw.add_ellipse(at, radius, imgui.get_color_u32(color), 0.0, 0, weight)
