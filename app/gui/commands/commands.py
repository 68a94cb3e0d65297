"""Every command of the window, in the order of the menus."""

from __future__ import annotations

import sys
from functools import partial

from imgui_bundle import imgui

from app.enhancement.settable import MODES, SLOTS, Mode, Slot
from app.gui.actions import (
    actions,
    clip_actions,
    comparing,
    enhancement_actions,
    export_actions,
    floating_windows,
    history_actions,
    live_actions,
    masking_actions,
    picture_actions,
    session_actions,
    summary_actions,
    tuning_actions,
)
from app.gui.commands import export_commands, recent_commands
from app.gui.commands.camera_commands import camera_sections
from app.gui.commands.command import Act, Command, Needs, Section, WindowServices, has_clip, is_live, menu
from app.gui.commands.edit_commands import edit_sections
from app.gui.commands.help_commands import help_sections
from app.gui.commands.job_commands import job_sections
from app.gui.commands.view_commands import view_sections
from app.gui.state.app_state import AppState

MODE_KEYS = dict(zip(MODES, ("V", "W", "T", "D"), strict=True))
MODE_TEXTS: dict[Mode, str] = {
    "side by side": "compare side by side",
    "wipe": "wipe: one pane with a line to drag",
    "flip": "flip: one pane, left or right",
    "difference": "difference: where left and right differ, and by how much",
}
MODE_SYNONYMS: dict[Mode, tuple[str, ...]] = {
    "side by side": ("split", "both", "two"),
    "wipe": ("split", "curtain", "divider", "before", "after"),
    "flip": ("blink", "toggle", "before", "after"),
    "difference": ("change", "subtract"),
}
open_folder = partial(actions.choose_path, kind="folder", take=actions.open_path)
open_file = partial(actions.choose_path, kind="file", take=actions.open_path)


def sections(state: AppState, outside: WindowServices) -> tuple[Section, ...]:
    """All commands as they are now: the recent clips are among them."""
    return (
        *_file(state, outside),
        *_picture(state),
        *_compare(),
        *_clip(),
        *job_sections(),
        *camera_sections(state),
        *edit_sections(),
        *view_sections(outside),
        *help_sections(),
    )


def _lacks(state: AppState) -> str:
    shown = state.picture.pictures is not None or state.scene.model is not None
    return "" if shown else "Open a clip, a run or a splat file first."


has_time = Needs(lambda state: "" if state.moments > 0 else "Open a clip or a run first.")
has_something = Needs(_lacks)


def _file(state: AppState, outside: WindowServices) -> tuple[Section, ...]:
    opening = (
        Command("Open folder…", open_folder, ("Ctrl+O",),
                synonyms=("load", "case", "directory", "dataset", "import", "browse")),
        Command("Open file…", open_file, ("Ctrl+I",), text="open an image, a video, a session or a report",
                synonyms=("load", "image", "video", "session", "report", "movie", "still", "run", "import",
                          "film")),
        Command("Open live source…", live_actions.choose_source, ("Ctrl+L",),
                text="a capture device, a stream, a file as if live, or two for both eyes",
                synonyms=("camera", "capture", "stream", "rtsp", "webcam", "grabber", "device", "record",
                          "stereo", "endoscope", "microscope", "usb", "connect")),
        Command("Try the built-in clip", actions.open_phantom,
                synonyms=("demo", "example", "sample", "phantom", "test")),
    )  # fmt: skip
    remember = (
        Command("Remember recent files", _toggle_recent, ticked=lambda s: s.settings.remember_recent,
                text="keep a list of opened files; turning this off clears it",
                synonyms=("history", "privacy", "forget", "preferences", "options")),
    )  # fmt: skip
    saving = (
        Command("Save image", export_actions.save_picture, ("S",), text="save an image of what is shown",
                applies=has_something,
                synonyms=("picture", "screenshot", "snapshot", "capture", "png", "copy", "still")),
        Command("Save the whole window", export_actions.save_window, ("F12",),
                text="save an image of the window as it is",
                synonyms=("screenshot", "capture", "print", "screen")),
        Command("Export…", lambda s: floating_windows.toggle(s.exports), ("Ctrl+Shift+E",),
                text="export images, videos, measures and 3D models", applies=has_something,
                synonyms=("mp4", "video", "movie", "record", "share", "csv", "table", "png", "jpeg", "tiff",
                          "film", "render", "save", "send", "powerpoint")),
        Command("Add to the case summary", summary_actions.add_shown, ("Ctrl+J",),
                text="save what is shown with its measures, for a page to print", applies=has_something,
                synonyms=("report", "pdf", "html", "print", "collect")),
        Command("Case summary…", lambda s: floating_windows.toggle(s.summary), ("Ctrl+Shift+J",),
                text="saved images with settings, measures and notes on one page to print",
                synonyms=("report", "pdf", "html", "print", "document", "notes")),
        Command("Enhance files and folders…", lambda s: floating_windows.toggle(s.batches), ("Ctrl+Shift+B",),
                text="enhance many images, videos and folders with the current settings",
                synonyms=("batch", "convert", "many", "process")),
        Command("Record the live source", live_actions.toggle_recording, ("Ctrl+Shift+L",),
                text="record the live source, or end the recording",
                applies=is_live, ticked=lambda s: s.live.recorder is not None,
                synonyms=("video", "capture", "mp4", "store")),
        Command("Send the live source to 3D Slicer", live_actions.toggle_sending,
                text="other programs can fetch the enhanced frames by OpenIGTLink, or no more",
                applies=is_live, ticked=lambda s: s.live.sender is not None,
                synonyms=("igtl", "openigtlink", "share", "stream", "network")),
        Command("Close the live source", live_actions.leave_live,
                applies=is_live, synonyms=("stop", "end", "disconnect")),
        Command("Save session", session_actions.save, ("Ctrl+S",), while_typing=True,
                text="save the open files, settings, views and notes; open it like a clip",
                applies=session_actions.has_content, synonyms=("project", "workspace", "store")),
        Command("Save session as…", session_actions.save_as, ("Ctrl+Shift+S",), while_typing=True,
                text="save the session by another name", applies=session_actions.has_content),
        Command("New case", session_actions.ask_new_case, text="start notes and case summary afresh",
                applies=session_actions.has_case,
                synonyms=("patient", "clear", "reset", "empty", "notes", "summary")),
    )  # fmt: skip
    exported = (
        Command("Show the last export in its folder", export_actions.reveal,
                text="in the system's file manager", applies=lambda s: s.exports.last is not None),
    )  # fmt: skip
    quitting = (
        Command("Quit", lambda s: outside.quit(), ("Ctrl+Q",), while_typing=True,
                synonyms=("exit", "close", "leave", "end")),
    )  # fmt: skip
    return (
        Section("File", opening),
        Section("File", recent_commands.opening(state), "Open recent"),
        *menu("File", remember, saving),
        Section("File", export_commands.exporting(), "Export as"),
        *menu("File", exported, quitting),
    )


def _toggle_recent(state: AppState) -> None:
    actions.remember_recent(state, not state.settings.remember_recent)


def _picture(state: AppState) -> tuple[Section, ...]:
    looks = (
        Command("Enhancement", enhancement_actions.toggle_enhancement, ("E",), text="enhancement on or off",
                applies=has_clip, ticked=lambda s: s.enhancement.active,
                synonyms=("vessel", "vessels", "enhance", "filter", "brighter", "brightness", "contrast",
                          "on", "off", "sharpen", "colour", "color", "saturation", "gamma", "clahe",
                          "angiography", "darker", "noise", "denoise", "strength", "sliders")),
        Command("Plain white light", enhancement_actions.white_light, ("Shift+W",), applies=has_clip,
                text="white light: the frames as recorded, in all panes and the 3D view",
                synonyms=("original", "wli", "normal", "unenhanced", "before")),
        Command("Freeze", live_actions.toggle_freeze, ("F",), text="hold this frame in both panes",
                applies=has_clip, ticked=lambda s: s.is_frozen,
                synonyms=("hold", "still")),
    )  # fmt: skip
    zooms = (
        Command("Fit", lambda s: picture_actions.fit(s.picture), ("0",), text="fit the whole frame",
                applies=has_clip, synonyms=("zoom", "out", "reset", "view")),
        Command("1:1", one_to_one, ("1",), text="actual pixels (1:1)", applies=has_clip,
                synonyms=("zoom", "magnify", "100%", "actual", "size", "native", "enlarge", "magnifier",
                          "loupe")),
    )  # fmt: skip
    parameters = (
        Command(history_actions.undo_name(state), history_actions.undo, ("Ctrl+Z",),
                text="undo the last change", repeats=True,
                applies=lambda s: len(s.enhancement.past) > 1 and not s.editing.active,
                synonyms=("revert", "back")),
        Command(history_actions.redo_name(state), history_actions.redo, ("Ctrl+Y",),
                text="redo the last undone change", repeats=True,
                applies=lambda s: bool(s.enhancement.future) and not s.editing.active,
                synonyms=("repeat", "again")),
        Command("Reset all", enhancement_actions.reset_params, ("R",), applies=enhancement_actions.can_reset,
                text="all parameters, statistics and pixels to their defaults; the method stays",
                synonyms=("defaults", "factory", "clear")),
        Command("Tuning grid", tuning_actions.toggle_tuning, ("Ctrl+T",),
                text="tuning grid: compare a range of settings", ticked=lambda s: s.tuning.shown,
                synonyms=("parameters", "presets", "variants", "sweep", "explore", "optimise", "optimize")),
    )  # fmt: skip
    return menu("Image", looks, zooms, parameters)


def _compare() -> tuple[Section, ...]:
    sides = (
        Command("Swap left and right", comparing.swap, ("X",), applies=has_clip,
                synonyms=("exchange", "sides", "flip", "panes")),
        Command("Original left, enhanced right", comparing.reset_sources, applies=has_clip),
        Command("Wipe to the left", _wipe(-1), ("Shift+[",), applies=has_clip, repeats=True),
        Command("Wipe to the right", _wipe(1), ("Shift+]",), applies=has_clip, repeats=True),
        Command("Zebra: stripes on clipped pixels", comparing.toggle_zebra, ("Z",), applies=has_clip,
                ticked=lambda s: s.comparing.chosen.zebra,
                synonyms=("overexposed", "saturated", "exposure", "highlights", "glare", "reflections",
                          "burnt")),
    )  # fmt: skip
    slots = tuple(command for slot in SLOTS for command in _slot(slot))
    return menu("Compare", tuple(map(_mode, MODES)), sides, slots)


def _mode(mode: Mode) -> Command:
    act: Act = comparing.flip if mode == "flip" else partial(comparing.choose_mode, mode=mode)
    return Command(mode.capitalize(), act, (MODE_KEYS[mode],), text=MODE_TEXTS[mode], applies=has_clip,
                   synonyms=MODE_SYNONYMS[mode],
                   ticked=lambda s: s.comparing.chosen.mode == mode)  # fmt: skip


def _wipe(steps: int) -> Act:
    return lambda state: comparing.move_wipe(state, steps * comparing.WIPE_STEP)


def _slot(slot: Slot) -> tuple[Command, Command]:
    return (
        Command(f"Store settings {slot}", lambda s: comparing.store(s, slot), (f"Shift+{slot}",),
                applies=has_clip),
        Command(f"Use settings {slot}", lambda s: comparing.recall(s, slot),
                applies=lambda s: slot in s.enhancement.stored),
    )  # fmt: skip


def _clip() -> tuple[Section, ...]:
    time = (
        Command("Play", actions.toggle_play, ("Space", "P", "K"), text="play or pause",
                applies=lambda s: s.moments > 1, ticked=lambda s: s.timeline.playing,
                synonyms=("pause", "stop", "start", "video", "playback", "loop", "watch", "cine")),
        Command("Previous frame", partial(actions.step, frames=-1), ("Left", "comma"), applies=has_time,
                repeats=True),
        Command("Next frame", partial(actions.step, frames=1), ("Right", "period"), applies=has_time,
                repeats=True),
        Command("Ten frames back", partial(actions.step, frames=-10), ("Shift+Left",), applies=has_time,
                repeats=True),
        Command("Ten frames forward", partial(actions.step, frames=10), ("Shift+Right",), applies=has_time,
                repeats=True),
        Command("First frame", partial(actions.go_to_end, last=False), ("Home",), applies=has_time,
                text="first frame of the clip or of its trimmed part, or first image of the folder",
                synonyms=("begin", "beginning", "start", "rewind")),
        Command("Last frame", partial(actions.go_to_end, last=True), ("End",), applies=has_time,
                text="last frame of the clip or of its trimmed part, or last image of the folder",
                synonyms=("end", "finish")),
    )  # fmt: skip
    parts = (
        Command("In: start here", partial(clip_actions.trim_here, start=True), ("Shift+I",),
                text="start the clip at this frame",
                applies=Needs(clip_actions.why_not_trimmed),
                synonyms=("trim", "cut", "in", "point")),
        Command("Out: end here", partial(clip_actions.trim_here, start=False), ("Shift+O",),
                text="end the clip at this frame",
                applies=Needs(clip_actions.why_not_trimmed),
                synonyms=("trim", "cut", "out", "point")),
        Command("All: whole clip", clip_actions.untrim, text="from its first frame to its last",
                applies=lambda s: s.source.part.trim is not None),
        # macOS puts the window away by its own Cmd+M.
        Command("Mask tools by hand", masking_actions.toggle,
                ("Ctrl+Shift+M",) if sys.platform == "darwin" else ("Ctrl+Shift+M", "Ctrl+M"),
                text="mask surgical tools with a brush, or stop", ticked=lambda s: s.masking.active,
                applies=Needs(clip_actions.why_no_clip),
                synonyms=("instruments", "brush", "paint", "segment", "segmentation", "erase", "find",
                          "detect", "draw", "region", "annotate")),
        Command("Tint masked areas", clip_actions.toggle_overlay, ("Shift+M",),
                text="tint tools and masked areas", applies=has_clip, ticked=lambda s: s.picture.overlay,
                synonyms=("mask", "overlay", "instruments", "tools")),
    )  # fmt: skip
    return menu("Clip", time, parts)


def one_to_one(state: AppState) -> None:
    """One picture pixel a pixel of the screen, also where the window counts in larger units."""
    picture_actions.one_to_one(state.picture, 1 / imgui.get_io().display_framebuffer_scale.x)
