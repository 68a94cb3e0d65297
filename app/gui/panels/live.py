"""What is live: the bar in the timeline's place, and the dialog that asks for a source."""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import partial
from typing import Final

from imgui_bundle import ImVec2, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons

from app.files.legible import as_label
from app.gui.actions import actions, export_actions, live_actions
from app.gui.drawing.textures import ShowsPictures
from app.gui.panels.overlays import floating_window
from app.gui.state.app_state import AppState
from app.gui.state.live import EYES, RATES, SIZES
from app.gui.state.live_words import counts, delay_text, not_live, pace
from app.gui.style import theme
from app.gui.style.widgets import (
    button,
    choose,
    choose_row,
    em,
    explain,
    muted,
    note,
    row,
    tall,
    toggle,
)
from app.gui.views.clip_time import clock
from app.live.address import Device
from app.live.recorder import WHATS
from app.live.sources.device import PERMISSION

TITLE: Final = "Open live source"
WIDTH: Final = 34.0
COLUMN: Final = 7.8
"""Em of what is to be recorded, and of the button above."""
PREVIEW: Final = ImVec2(8.0, 4.5)
"""Em of a preview."""
HINT: Final = "rtsp://, udp://, http:// or a number"
ADDRESS_TEXT: Final = (
    "Number of a device, or address of a stream: rtsp://HOST/PATH, udp://@:PORT, http://HOST/PATH. A stream "
    "that you open here is the only thing that VesselSplat ever fetches from a network."
)
FILE_TEXT: Final = "Play a video or a folder of images at its own rate, in a loop, as if it were live."
SAVE_TEXT: Final = "S: save what is shown as an image, and beside it the frame as received."
RECORD_TEXT: Final = (
    "Ctrl+Shift+L: record into the export folder. Should the computer stop, at most the last second is lost."
)
SEND_TEXT: Final = (
    "Let 3D Slicer, or another program, fetch the enhanced frames by OpenIGTLink. Only programs of this "
    "computer can, unless VesselSplat was started with another address."
)
WHAT_TEXT: Final = (
    "What is recorded. Originals can be enhanced and reconstructed later; of a stereo source they hold both "
    "eyes, the others the left one."
)
EYES_TEXT: Final = (
    "For a stereo source: both eyes in each frame, the left one on the left or on top, or a source for each "
    "eye. The left eye is shown. Recordings of originals hold both and open with depth. As delivered: one "
    "eye, unless a file states otherwise."
)
RIGHT_TEXT: Final = (
    "Number or name of a device, address of a stream, or path of a file. What you open is the left eye. "
    "Frames that arrive within half a frame of each other are a pair."
)


def draw_live_bar(state: AppState) -> None:
    """Two rows: what can be done, and how the source stands."""
    live, status = state.live, state.live.status
    with imgui_ctx.push_style_var(imgui.StyleVar_.frame_padding, tall()):
        _draw_record(state)
        imgui.same_line()
        _draw_signal(state)
        imgui.same_line(_right())
        save = partial(export_actions.save_picture, state)
        button(f"{icons.ICON_FA_CAMERA}  Save image", save, SAVE_TEXT, width=9.0)
    with imgui_ctx.push_id("below"):
        what = choose("what", live.what, {one: one.capitalize() for one in WHATS}, WHAT_TEXT, COLUMN)
        if what != live.what and live.recorder is None:
            live_actions.choose_what(state, what)
        imgui.same_line()
        _draw_send(state)
        imgui.same_line()
        if status is not None:
            muted(counts(live, status))
            explain(delay_text(status))
        imgui.same_line(_right())
        button("Close source", partial(live_actions.leave_live, state), "End the live source.", width=9.0)


def _right() -> float:
    """Where the last column begins."""
    return imgui.get_window_width() - em(9.0) - imgui.get_style().window_padding.x


def _draw_record(state: AppState) -> None:
    recording, toggle = state.live.recording, partial(live_actions.toggle_recording, state)
    if recording is None:
        button(f"{icons.ICON_FA_CIRCLE}  Record###record", toggle, RECORD_TEXT, width=COLUMN)
        return
    label = f"{icons.ICON_FA_STOP}  {clock(recording.seconds)}###record"
    button(label, toggle, "Ctrl+Shift+L: end the recording.", color=theme.now().recording, width=COLUMN)


def _draw_send(state: AppState) -> None:
    sending, turn = state.live.sending, partial(live_actions.toggle_sending, state)
    if sending is None:
        button("Send###send", turn, SEND_TEXT, width=7.5)
        return
    said = f"{sending}; {sending.sent} images sent, {sending.left_out} left out. Click to end it."
    said = f"{said[0].upper()}{said[1:]}\n{state.live.endpoint.warning}".strip()
    far = not state.live.endpoint.is_local
    toggle("Sending###send", turn, said, on=True, caution=far, width=7.5)


def _draw_signal(state: AppState) -> None:
    status = state.live.status
    if status is None:
        return
    if status.is_live:
        imgui.text_unformatted(f"LIVE   {pace(status)}")
        explain(delay_text(status))
    else:
        imgui.text_colored(theme.now().warning, not_live(status))


def draw_live_choice(state: AppState, textures: ShowsPictures) -> None:
    """A window of its own."""
    choice = state.live.choice
    if not choice.shown:
        return
    with floating_window(state, choice, TITLE, WIDTH, imgui.WindowFlags_.no_saved_settings) as drawn:
        if not drawn:
            return
        _draw_devices(state, textures)
        imgui.separator_text("Stream or device by address")
        _draw_address(state)
        imgui.separator_text("Stereo")
        _draw_eyes(state)
        imgui.separator_text("Without a camera")
        take = partial(actions.choose_path, state, take=live_actions.play_file, purpose="file")
        button(f"{icons.ICON_FA_FILM}  Play a video as if live…", partial(take, "file"), FILE_TEXT)
        imgui.same_line()
        button("Play a folder…", partial(take, "folder", purpose="folder"), FILE_TEXT)
        imgui.separator_text("Request from the device")
        _draw_wish(state)


def _draw_devices(state: AppState, textures: ShowsPictures) -> None:
    found = state.live.choice.found
    imgui.align_text_to_frame_padding()
    if found is None:
        muted("Looking for capture devices…")
    elif not found.devices:
        muted("No capture device is connected.")
    else:
        muted("Capture devices")
    imgui.same_line(imgui.get_window_width() - em(8))
    look = partial(live_actions.choose_source, state)
    button(f"{icons.ICON_FA_SYNC}  Look again", look, "List the devices again.", width=7)
    if sys.platform == "darwin" and found is not None and not found.devices:
        note(f"Or macOS does not allow it: {PERMISSION}.")
    for one in found.devices if found is not None else ():
        _draw_device(state, one, textures)


def _draw_device(state: AppState, one: Device, textures: ShowsPictures) -> None:
    found = state.live.choice.found
    preview = found.previews.get(one.where) if found is not None else None
    with imgui_ctx.push_id(one.where):
        if preview is not None:
            width = em(PREVIEW.y) * preview.shape[1] / preview.shape[0]
            imgui.image(textures.whole(f"device {one.where}", preview), ImVec2(width, em(PREVIEW.y)))
            imgui.same_line()
        if state.live.choice.eyes == "two":
            take = partial(live_actions.type_right, state, one.where)
            button("Right eye###right", take, "Take this one for the right eye.", width=6)
            imgui.same_line()
        label = f"{as_label(one.name)}###open"
        button(label, partial(live_actions.open_device, state, one), "Open this device.", width=-1)


def _draw_address(state: AppState) -> None:
    choice = state.live.choice
    imgui.set_next_item_width(-em(5))
    flags = imgui.InputTextFlags_.enter_returns_true
    entered, text = imgui.input_text_with_hint("##address", HINT, choice.text, flags)
    if text != choice.text:
        live_actions.type_address(state, text)
    explain(ADDRESS_TEXT)
    imgui.same_line()
    opened = partial(live_actions.open_typed, state)
    button("Open###typed", opened, ADDRESS_TEXT, enabled=bool(choice.text.strip()), width=4.5)
    if entered and choice.text.strip():
        opened()
    if choice.trouble:
        note(choice.trouble, theme.now().warning)


def _draw_eyes(state: AppState) -> None:
    choice = state.live.choice
    eyes = choose_row("Eyes", choice.eyes, EYES, EYES_TEXT)
    if eyes != choice.eyes:
        live_actions.choose_eyes(state, eyes)
    if eyes != "two":
        return
    row("Right eye", RIGHT_TEXT)
    changed, text = imgui.input_text_with_hint("##right", HINT, choice.right)
    explain(RIGHT_TEXT)
    if changed:
        live_actions.type_right(state, text)


def _draw_wish(state: AppState) -> None:
    wish = state.live.choice.wish
    size = choose_row(
        "Size", wish.size, SIZES, "For devices, which may deliver another size: the bar below shows it."
    )
    rate = choose_row("Frames/s", wish.frames_per_second, RATES, "For devices, and files that are played.")
    if (size, rate) != (wish.size, wish.frames_per_second):
        live_actions.choose_wish(state, replace(wish, size=size, frames_per_second=rate))
