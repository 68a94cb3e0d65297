"""Keys: which chord a user's name for it is, and what the keyboard does to the state."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache

from imgui_bundle import imgui

from app.gui.actions import camera_actions, enhancement_actions, escape
from app.gui.commands.command import Command, Section
from app.gui.commands.modes import Keys, keys_of
from app.gui.commands.walking import Walk
from app.gui.state.app_state import AppState

MODIFIERS = int(imgui.Key.mod_mask_)
PEEK = imgui.Key.o
PEEK_TEXT = "hold: the original in every pane"
FLIGHT = {
    imgui.Key.a: (-1, 0, 0), imgui.Key.d: (1, 0, 0),
    imgui.Key.q: (0, 1, 0), imgui.Key.e: (0, -1, 0),
    imgui.Key.s: (0, 0, -1), imgui.Key.w: (0, 0, 1),
}  # fmt: skip
"""Right, down and forward. In flight these keys do nothing else."""
FLIGHT_TEXT = "when flying: forward and back, left and right, down and up; the wheel sets the speed"
MOUSE = (
    ("Wheel", "zoom at the pointer, in both panes or the 3D view"),
    ("Drag", "pan the panes; orbit the 3D view, or look around when flying"),
    ("Right drag", "pan the 3D view"),
    ("Double click", "fit the panes; orbit the 3D view around this point (also U); reset a slider"),
    ("Ctrl+click on a slider", "type a value"),
)
# A sum of two keys is a number: as an enum it is a member that Python 3.11.2, Debian 12's, cannot make.
SHIFT = int(imgui.Key.mod_shift)
SHIFT_SLASH = SHIFT + int(imgui.Key.slash)
PLUS = int(imgui.Key.equal)
"""With Shift and without: many keyboards have "+" on it only with Shift."""
NAMED = {
    "F1": imgui.Key.f1, "F5": imgui.Key.f5,
    "Esc": imgui.Key.escape, "Del": imgui.Key.delete, "Home": imgui.Key.home,
    "PageUp": imgui.Key.page_up, "PageDown": imgui.Key.page_down,
    "Tab": imgui.Key.tab, "End": imgui.Key.end, "Left": imgui.Key.left_arrow, "Right": imgui.Key.right_arrow,
    "Space": imgui.Key.space, "comma": imgui.Key.comma, "period": imgui.Key.period, "?": SHIFT_SLASH,
    "plus": imgui.Key.equal, "minus": imgui.Key.minus,
    "keypad plus": imgui.Key.keypad_add, "keypad minus": imgui.Key.keypad_subtract,
    "[": imgui.Key.left_bracket, "]": imgui.Key.right_bracket, "0": imgui.Key._0, "1": imgui.Key._1,
}  # fmt: skip
CLAIMED = (
    imgui.Key.space, imgui.Key.home, imgui.Key.end, imgui.Key.left_arrow, imgui.Key.right_arrow,
    imgui.Key.up_arrow, imgui.Key.down_arrow, imgui.Key.tab,
)  # fmt: skip
"""Unless claimed, they walk from control to control, and press the one in focus."""
PAGES = (imgui.Key.page_up, imgui.Key.page_down)
"""Claimed as well while the guide is open, whose pages they turn; else they scroll."""
OWNER = 0x6B657973
"""Any number that no control has."""
WALK = SHIFT | int(imgui.Key.tab)
WALK_TEXT = "go through the controls by keyboard, on with Tab and arrows, Space to press; Esc ends it"
PANELS = {int(imgui.Key.f6): 1, SHIFT | int(imgui.Key.f6): -1}
PANELS_TEXT = "go to the next panel, the menus or the timeline by keyboard; Shift+F6: back"
LEAVE = int(imgui.Key.escape)
LEAVE_TEXT = "leave the innermost: menu, dialog, tool, tile, presentation, images alone, full screen, error"
HELD = {"Ctrl": imgui.Key.mod_ctrl, "Shift": imgui.Key.mod_shift}


@cache
def chord(keys: str) -> int:
    """ImGui's number for keys that are pressed together, "Ctrl+Shift+E".

    Raises KeyError or AttributeError for a name that no key has.
    """
    *held, name = keys.split("+")
    key = NAMED[name] if name in NAMED else getattr(imgui.Key, name.lower())
    return sum(int(HELD[one]) for one in held) | int(key)


class Keyboard:
    """Acts on the keys of each frame; typing and open dialogs keep theirs."""

    def __init__(self) -> None:
        self._was_free = True
        self._walked = False
        self.walk = Walk()

    def handle(self, state: AppState, sections: Iterable[Section]) -> None:
        io = imgui.get_io()
        asked = imgui.is_popup_open("", imgui.PopupFlags_.any_popup)
        free = not io.want_text_input and not asked
        # The key that has just closed a menu or ended typing has done its work.
        acts, self._was_free = free and self._was_free, free
        enhancement_actions.peek(
            state, not io.want_text_input and not io.key_mods and imgui.is_key_down(PEEK)
        )
        # While controls are walked by keyboard, these keys are of the walk, and Escape ends it.
        walks, self._walked = io.nav_visible or self._walked, io.nav_visible
        if free and not walks:
            _claim(io.key_mods, CLAIMED + PAGES if state.guide.shown else CLAIMED)
            if _is_pressed(WALK, False):
                # Shift and Tab of one frame: Tab was claimed before Shift was seen.
                imgui.set_nav_cursor_visible(True)
                self.walk.ask(0)
        for code, steps in PANELS.items():
            if acts and _is_pressed(code, True):
                self.walk.ask(steps)
        flies = state.scene.viewer.flying
        if acts and not walks and _is_pressed(LEAVE, False):
            escape.leave_innermost(state, _nearness)
        modal = keys_of(state) if acts and not walks else {}
        typing = io.want_text_input and not asked
        pressed = _pressed(state, sections, modal, walks) if acts or typing else []
        for command in pressed if acts else [one for one in pressed if one.while_typing]:
            if command.applies(state):
                command.act(state)
            elif command.refuse is not None:
                command.refuse(state)
        for code, act in modal.items():
            if _is_pressed(code, True):
                act(state)
        held = FLIGHT if acts and flies and not io.key_mods else {}
        _fly(state, [way for key, way in held.items() if imgui.is_key_down(key)], io.delta_time)


def _nearness(title: str) -> int:
    """Of a window: the later it came into focus, the larger; least before it is drawn."""
    window: imgui.internal.Window | None = imgui.internal.find_window_by_name(title)
    return -1 if window is None else window.focus_order


def _claim(held: int, keys: Iterable[imgui.Key]) -> None:
    """Until the next frame these keys are ours alone; with Shift, Tab begins a walk."""
    if held & ~SHIFT:
        return
    for key in keys:
        if not (held and key == imgui.Key.tab):
            imgui.internal.set_key_owner(key, OWNER)


def _pressed(state: AppState, sections: Iterable[Section], modal: Keys, walks: bool) -> list[Command]:
    """Commands that apply, or say why not, whose keys went down; keys of a mode, a flight or a walk do
    nothing else."""
    flies = state.scene.viewer.flying
    return [
        command
        for section in sections
        for command in section.commands
        for keys in command.keys
        if _is_pressed(code := chord(keys), command.repeats)
        and code not in modal
        and not (flies and code in FLIGHT)
        and not (walks and code & ~MODIFIERS in CLAIMED + PAGES)
        and (command.applies(state) or command.refuse is not None)
    ]


def _is_pressed(code: int, repeats: bool) -> bool:
    """Exactly this chord; a held key counts again only where that is wanted."""
    if not imgui.is_key_pressed(imgui.Key(code & ~MODIFIERS), repeats):
        return False
    held, wanted = _held(), code & MODIFIERS
    return held == wanted or (code & ~MODIFIERS == PLUS and held == wanted | SHIFT)


def _held() -> int:
    """Modifiers of this frame's keys: a quick hand has let go of them by the end of a slow frame."""
    let_go = sum(int(one) for one in HELD.values() if imgui.is_key_released(one))
    return imgui.get_io().key_mods | let_go


def _fly(state: AppState, ways: list[tuple[int, int, int]], seconds: float) -> None:
    """Where the held keys together lead."""
    right, down, forward = (sum(way[axis] for way in ways) for axis in range(3))
    moving = any((right, down, forward))
    camera_actions.hold_flight(state, moving)
    if moving:
        camera_actions.fly(state, right, down, forward, seconds)
