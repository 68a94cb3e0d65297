"""Every key of the window in one table: what it does, and the text of the help."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from imgui_bundle import imgui

from app.gui import (
    actions,
    camera_actions,
    clip_actions,
    comparing,
    edit_actions,
    export_actions,
    path_actions,
    tuning_actions,
    view_actions,
)
from app.gui.editing import Tool
from app.gui.picture_view import PictureView
from app.gui.state import AppState


@dataclass(frozen=True)
class Shortcut:
    """A chord of keys and what it does to the state."""

    chord: int
    keys: str
    """As a person reads it."""
    text: str
    act: Callable[[AppState], None]
    repeats: bool = False


@dataclass(frozen=True)
class Commands:
    """What keys can start that needs more than the state."""

    open_folder: Callable[[], None]
    open_file: Callable[[], None]
    screenshot: Callable[[], None]
    session: Callable[[], None]


BLEND_STEP = 0.1
TOOL_KEYS: dict[Tool, str] = {
    "look": "Shift+V", "rectangle": "Shift+R", "lasso": "Shift+L", "sphere": "Shift+S", "box": "Shift+K"
}  # fmt: skip
MODIFIERS = int(imgui.Key.mod_mask_)
PEEK = imgui.Key.space
PEEK_TEXT = "hold: the original in every pane"
FLIGHT = {
    imgui.Key.a: (-1, 0, 0), imgui.Key.d: (1, 0, 0),
    imgui.Key.q: (0, 1, 0), imgui.Key.e: (0, -1, 0),
    imgui.Key.s: (0, 0, -1), imgui.Key.w: (0, 0, 1),
}  # fmt: skip
"""Right, down and forward. In flight these keys do nothing else."""
FLIGHT_TEXT = "in flight: forward and back, left and right, down and up; the wheel sets the speed"
MOUSE = (
    ("Wheel", "zoom at the pointer, both pictures or the 3D view"),
    ("Drag", "move the pictures; turn the 3D view around its centre, in flight on the spot"),
    ("Right drag", "move the 3D view"),
    ("Double click", "fit the pictures; turn the 3D view around this point; slider back to its default"),
    ("Ctrl+click on a slider", "type a value"),
)


def shortcuts(commands: Commands) -> tuple[Shortcut, ...]:
    """In the order of the help."""
    key, ctrl, shift = imgui.Key, imgui.Key.mod_ctrl, imgui.Key.mod_shift
    return (
        Shortcut(key.e, "E", "enhancement on and off", actions.toggle_enhancement),
        Shortcut(key.escape, "Esc", "plain white light", actions.white_light),
        Shortcut(key.v, "V", "compare side by side", lambda s: comparing.choose_mode(s, "side by side")),
        Shortcut(
            key.w, "W", "wipe: one picture with a line to drag", lambda s: comparing.choose_mode(s, "wipe")
        ),
        Shortcut(key.t, "T", "one picture: flip between left and right", comparing.flip),
        Shortcut(
            key.d, "D", "difference of left and right", lambda s: comparing.choose_mode(s, "difference")
        ),
        Shortcut(key.x, "X", "swap left and right", comparing.swap),
        Shortcut(
            shift | key.left_bracket, "Shift+[", "line of the wipe to the left", _wipe(-1), repeats=True
        ),
        Shortcut(
            shift | key.right_bracket, "Shift+]", "line of the wipe to the right", _wipe(1), repeats=True
        ),
        Shortcut(key.z, "Z", "stripes on clipped pixels", comparing.toggle_zebra),
        Shortcut(shift | key.a, "Shift+A", "store the setting as A", lambda s: comparing.store(s, "A")),
        Shortcut(shift | key.b, "Shift+B", "store the setting as B", lambda s: comparing.store(s, "B")),
        Shortcut(key.f, "F", "freeze the pictures", actions.toggle_freeze),
        Shortcut(key.p, "P", "play and pause", actions.toggle_play),
        Shortcut(key.k, "K", "play and pause", actions.toggle_play),
        Shortcut(
            shift | key.i, "Shift+I", "the clip begins here", lambda s: clip_actions.trim_here(s, start=True)
        ),
        Shortcut(
            shift | key.o, "Shift+O", "the clip ends here", lambda s: clip_actions.trim_here(s, start=False)
        ),
        Shortcut(shift | key.m, "Shift+M", "tint tools and what is masked", clip_actions.toggle_overlay),
        Shortcut(key.comma, "comma", "one frame back", lambda s: actions.step(s, -1), repeats=True),
        Shortcut(key.period, "full stop", "one frame on", lambda s: actions.step(s, 1), repeats=True),
        Shortcut(key.home, "Home", "3D view back to the clip's camera", camera_actions.reset_view),
        Shortcut(key.c, "C", "3D view to the clip's camera, under its photo", camera_actions.toggle_snap),
        Shortcut(key.left_bracket, "[", "less of the photo over the 3D view", fade_photo, repeats=True),
        Shortcut(key.right_bracket, "]", "more of the photo over the 3D view", raise_photo, repeats=True),
        Shortcut(key.g, "G", "fly through the 3D view and back to turning it", camera_actions.toggle_flight),
        Shortcut(key.n, "N", "3D view: colour, depth, normals and on", view_actions.next_view),
        Shortcut(key.m, "M", "measure between two clicks on the 3D view", camera_actions.toggle_measuring),
        Shortcut(key.b, "B", "keep this 3D view by a name", path_actions.save_view),
        Shortcut(key.i, "I", "add this 3D view to the camera path", path_actions.add_keyframe),
        Shortcut(key.l, "L", "play the camera path", path_actions.toggle_path),
        Shortcut(key._0, "0", "fit the pictures", fit_pictures),
        Shortcut(key._1, "1", "pictures at 100 %", one_to_one),
        Shortcut(key.r, "R", "reset all enhancement parameters", actions.reset_params),
        Shortcut(
            ctrl | key.z, "Ctrl+Z", "undo a parameter, in edit mode an edit", edit_actions.undo, repeats=True
        ),
        Shortcut(
            ctrl | key.y, "Ctrl+Y", "redo a parameter, in edit mode an edit", edit_actions.redo, repeats=True
        ),
        Shortcut(ctrl | key.t, "Ctrl+T", "tuning grid: a range of settings", tuning_actions.toggle_tuning),
        *edit_shortcuts(),
        Shortcut(key.s, "S", "save a picture of what is shown", lambda s: commands.screenshot()),
        Shortcut(
            ctrl | shift | key.e,
            "Ctrl+Shift+E",
            "export panes, videos and measures",
            export_actions.toggle_export,
        ),
        Shortcut(ctrl | key.s, "Ctrl+S", "save the session", lambda s: commands.session()),
        Shortcut(ctrl | key.o, "Ctrl+O", "open a folder", lambda s: commands.open_folder()),
        Shortcut(ctrl | key.i, "Ctrl+I", "open an image or a video", lambda s: commands.open_file()),
        Shortcut(shift | key.slash, "?", "this help", toggle_help),
        Shortcut(key.f1, "F1", "this help", toggle_help),
    )


def edit_shortcuts() -> tuple[Shortcut, ...]:
    """Of edit mode; all but the first do nothing outside it."""
    key, ctrl, shift = imgui.Key, imgui.Key.mod_ctrl, imgui.Key.mod_shift
    return (
        Shortcut(ctrl | key.e, "Ctrl+E", "edit the reconstruction, and end that", edit_actions.toggle),
        *(
            Shortcut(
                shift | getattr(key, keys[-1].lower()),
                keys,
                f"edit: {tool}",
                partial(edit_actions.choose_tool, tool=tool),
            )
            for tool, keys in TOOL_KEYS.items()
        ),
        Shortcut(ctrl | key.a, "Ctrl+A", "edit: select all", edit_actions.select_all),
        Shortcut(ctrl | key.d, "Ctrl+D", "edit: select none", edit_actions.select_none),
        Shortcut(ctrl | shift | key.i, "Ctrl+Shift+I", "edit: invert the selection", edit_actions.invert),
        Shortcut(key.delete, "Del", "edit: delete the selected Gaussians", edit_actions.delete),
        Shortcut(shift | key.delete, "Shift+Del", "edit: crop, delete all others", edit_actions.crop),
        Shortcut(key.h, "H", "edit: hide the selected Gaussians", edit_actions.hide),
        Shortcut(shift | key.h, "Shift+H", "edit: show what is hidden", edit_actions.show_hidden),
        Shortcut(ctrl | shift | key.s, "Ctrl+Shift+S", "save the edits", save_edits),
    )


def save_edits(state: AppState) -> None:
    if state.editing.is_unsaved:
        edit_actions.save(state)


def fade_photo(state: AppState) -> None:
    camera_actions.blend(state, state.viewer.blend - BLEND_STEP)


def raise_photo(state: AppState) -> None:
    camera_actions.blend(state, state.viewer.blend + BLEND_STEP)


def _wipe(steps: int) -> Callable[[AppState], None]:
    return lambda state: comparing.move_wipe(state, steps * comparing.WIPE_STEP)


def fit_pictures(state: AppState) -> None:
    state.picture_view = PictureView()


def one_to_one(state: AppState) -> None:
    """One picture pixel a pixel of the screen, also where the window counts in larger units."""
    state.picture_view = state.picture_view.one_to_one(1 / imgui.get_io().display_framebuffer_scale.x)


def toggle_help(state: AppState) -> None:
    state.help_open = not state.help_open


class Keyboard:
    """Acts on the keys of each frame; typing and open dialogs keep theirs."""

    def __init__(self, table: tuple[Shortcut, ...]) -> None:
        self.table = table
        self._was_free = True

    def handle(self, state: AppState) -> None:
        io = imgui.get_io()
        free = not io.want_text_input and not imgui.is_popup_open("", imgui.PopupFlags_.any_popup)
        # The key that has just closed a menu or ended typing has done its work.
        acts, self._was_free = free and self._was_free, free
        # While controls are walked by keyboard, Space presses the one in focus.
        state.peeking = acts and not io.nav_visible and imgui.is_key_down(PEEK)
        flies = state.viewer.flying
        for entry in self.table if acts else ():
            if _pressed(entry) and not (flies and entry.chord in FLIGHT):
                entry.act(state)
        held = FLIGHT if acts and flies and not io.key_mods else {}
        _fly(state, [way for key, way in held.items() if imgui.is_key_down(key)], io.delta_time)


def _pressed(entry: Shortcut) -> bool:
    """Exactly this chord; a held key counts again only where that is wanted."""
    modifiers = entry.chord & MODIFIERS
    key = imgui.Key(entry.chord & ~MODIFIERS)
    return imgui.get_io().key_mods == modifiers and imgui.is_key_pressed(key, entry.repeats)


def _fly(state: AppState, ways: list[tuple[int, int, int]], seconds: float) -> None:
    """Where the held keys together lead."""
    right, down, forward = (sum(way[axis] for way in ways) for axis in range(3))
    state.viewer.moving = any((right, down, forward))
    if state.viewer.moving:
        camera_actions.fly(state, right, down, forward, seconds)
