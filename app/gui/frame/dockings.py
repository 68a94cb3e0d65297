"""What the runner does with panels and with the window when it is asked to."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final, Literal

import glfw
from imgui_bundle import ImVec2, glfw_utils, hello_imgui, imgui

from app.gui.actions import laid_out, notes_actions, window_actions
from app.gui.panels import masking
from app.gui.panels.editing import PANEL as EDIT
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.work import kept_layout
from app.gui.work.opening import Content

SPLATS = "Splat file"
"""The 3D view of a model without pictures, in their place."""
Node = imgui.internal.DockNode
SIDE = 20.8
"""Lines of text that the panels at the side are wide."""
SIDE_OF_TABS = 24.0
"""The same where all of them are tabs beside each other, whose titles are whole."""
LEAST, MOST = 0.2, 0.45
"""Share of the window's width, or height, that they have at least and at most."""
HIGH = 31.0
"""Lines of text that they are high where they are below the images."""
LOW = 40.0
"""Lines of text that a window needs for panels below each other."""
UPRIGHT = 1.2
"""Height over width of a window from which on they are below the images, which they would make narrow."""
BELOW = dict.fromkeys(("3D view", "Log", "Notes"), ("Below", "MainDockSpace")) | dict.fromkeys(
    ("Reconstruction", "Runs", "Cameras"), ("SideBelow", "Side")
)
"""Panels that stand below others, and where they join these."""
TUNING, REPORT = "Tuning", "Report"
MASKS = masking.PANEL
LAYOUTS: Final[Mapping[Content, str]] = {"clip": "Default", "stills": "Stills", "run": "Run"}
"""By what is open, under the names that the runner keeps."""


def toggle(name: str) -> None:
    """Show the panel, in front, or hide it."""
    panel = _docking().dockable_window_of_name(name)
    panel.is_visible = not panel.is_visible
    panel.focus_window_at_next_frame = panel.is_visible


def is_shown(name: str) -> bool:
    return bool(_docking().dockable_window_of_name(name).is_visible)


def restore() -> None:
    """Every panel back to where it was at the very start, with this kind of content."""
    _docking().layout_reset = True


def restore_all() -> None:
    """With every kind of content, also one that is opened in a later session alone."""
    params = hello_imgui.get_runner_params()
    for docking in _all_dockings(params):
        docking.layout_reset = True
    if not params.ini_disable:
        kept_layout.forget(Path(params.ini_filename))


def quit_app() -> None:
    hello_imgui.get_runner_params().app_shall_exit = True


def window_size(*, first: bool) -> tuple[int, int]:
    """Pixels across and down; in the `first` frame those of the next, with which the runner makes the window
    larger for a dense screen."""
    width, height = glfw.get_window_size(glfw_utils.glfw_window_hello_imgui())
    if not first:
        return width, height
    factor, most = hello_imgui.dpi_window_size_factor(), glfw.get_video_mode(glfw.get_primary_monitor()).size
    return min(round(factor * width), most.width), min(round(factor * height), most.height)


def tabs(size: tuple[int, int], text_percent: int) -> dict[str, bool]:
    """Which parts of a window of so many pixels are not divided at first: too few lines of this text."""
    low, line = size[1] < LOW * _line(text_percent), _line(text_percent)
    # Below the images two are beside each other where both are as wide as at the side.
    return {"MainDockSpace": low, "Side": 2 * SIDE * line > size[0] if is_upright(size) else low}


def is_upright(size: tuple[int, int]) -> bool:
    return size[1] > UPRIGHT * size[0]


def _line(text_percent: int) -> float:
    """Pixels of a line of text."""
    return theme.FONT_SIZE * text_percent / 100 * hello_imgui.dpi_window_size_factor()


def layouts(make: Callable[[], hello_imgui.DockingParams]) -> list[hello_imgui.DockingParams]:
    """One of each kind of content, which the runner keeps each for itself; that of clips is the first."""
    made = []
    for name in LAYOUTS.values():
        layout = make()
        layout.layout_name = name
        made.append(layout)
    return made


def follow_content(state: AppState) -> None:
    """The layout of what was opened: a reconstruction that begins beside a clip moves nothing."""
    content = state.source.content
    wanted = hello_imgui.current_layout_name() if content is None else LAYOUTS[content]
    if wanted != hello_imgui.current_layout_name():
        hello_imgui.switch_layout(wanted)
        window_actions.note_layout(state)
        # With stills it shares its place with what reconstructs, which may have been used last.
        _docking().dockable_window_of_name("Enhancement").focus_window_at_next_frame = True


def arrange(params: hello_imgui.RunnerParams, size: tuple[int, int], text_percent: int) -> None:
    """Where panels are at first and after a reset; in a low window those below join those above, as tabs.
    Stills have the enhancement over all of the side: what reconstructs is behind it."""
    upright = is_upright(size)
    for docking in _all_dockings(params):
        whole = tabs(size, text_percent)
        whole["Side"] |= docking.layout_name == LAYOUTS["stills"]
        lines = _lines(whole["Side"], upright=upright)
        share = min(max(lines * _line(text_percent) / max(size[upright], 1), LEAST), MOST)
        docking.docking_splits = splits(share, whole, upright=upright)
        for panel in docking.dockable_windows:
            if panel.label in BELOW:
                below, above = BELOW[panel.label]
                panel.dock_space_name = above if whole[above] else below


def _lines(are_tabs: bool, *, upright: bool) -> float:
    """Across which the panels at the side are wide, or high where they are below the images."""
    return HIGH if upright else SIDE_OF_TABS if are_tabs else SIDE


def _all_dockings(params: hello_imgui.RunnerParams) -> tuple[hello_imgui.DockingParams, ...]:
    return params.docking_params, *params.alternative_docking_layouts


def splits(side: float, tabs: Mapping[str, bool], *, upright: bool) -> list[hello_imgui.DockingSplit]:
    """How the window is divided at first: pictures, below them the 3D view, two panels at the side, which has
    that share of the width, or in an `upright` window below all, of the height; where there are `tabs`, they
    are not divided."""
    split, right, down = hello_imgui.DockingSplit, imgui.Dir.right, imgui.Dir.down
    column = split("MainDockSpace", "Side", down if upright else right, side)
    both = split("Side", "SideBelow", right, 0.5) if upright else split("Side", "SideBelow", down, 0.46)
    below = both, split("MainDockSpace", "Below", down, 0.52)
    return [column, *(one for one in below if not tabs[one.initial_dock])]


def widen(before: int, now: int, *, upright: bool) -> None:
    """The panels at the side, or below all, as text of another percentage needs them: controls keep their
    proportions."""
    axis = imgui.internal.Axis.y if upright else imgui.internal.Axis.x
    column = _divided("Enhancement", axis)
    if column is not None:
        most = MOST * imgui.get_main_viewport().size[axis]
        # Where there was no room to grow, the size tells nothing of how large they are with other text. What
        # divides them from the images has taken its part of it.
        is_full = now < before and column.size[axis] > most - 1 - imgui.get_style().docking_separator_size
        are_tabs = _node_of(_window("Reconstruction")) == _node_of(_window("Enhancement"))
        least = _lines(are_tabs, upright=upright) * _line(now) if is_full else 0.0
        size = ImVec2(column.size.x, column.size.y)
        size[axis] = min(max(now / before * column.size[axis], least), most)
        imgui.internal.dock_builder_set_node_size(column.id_, size)


def _divided(name: str, axis: imgui.internal.Axis) -> Node | None:
    """Where the panel is docked, with what shares its side of a division along the axis; None without one."""
    node = _node_of(_window(name))
    while (above := _parent_of(node)) is not None and above.split_axis != axis:
        node = above
    return None if above is None else node


def _window(name: str) -> imgui.internal.Window | None:
    """None before it is drawn for the first time."""
    window: imgui.internal.Window | None = imgui.internal.find_window_by_name(name)
    return window


def _node_of(window: imgui.internal.Window | None) -> Node | None:
    return None if window is None else window.dock_node


def _parent_of(node: Node | None) -> Node | None:
    return None if node is None else node.parent_node


def spare_ground() -> None:
    """A docked panel is as the window is behind it: a software driver is spared painting that once more."""
    can, ground = imgui.WindowFlags_, imgui.get_color_u32(theme.now().ground)
    for panel in _docking().dockable_windows:
        node = _node_of(_window(panel.label))
        docked = _in_window(node)
        if node is not None:
            # What its place shows for a frame once it is hidden: of panels that paint no ground, white.
            node.last_bg_color = ground
        # It comes back with a session, too, or once all panels do: behind the images, if it was there.
        quiet = can.no_focus_on_appearing if panel.label == TUNING else can.none
        panel.imgui_window_flags = (can.no_background if docked else can.none) | quiet


def _bring_title_into_sight() -> None:
    """Of a panel that comes to the front otherwise than by its tab, which may be scrolled out of sight."""
    focused: imgui.internal.Window | None = imgui.get_current_context().nav_window
    window = None if focused is None else focused.root_window
    node = _node_of(window)
    if window is None or node is None or node.tab_bar is None:
        return
    if node.tab_bar.selected_tab_id != window.tab_id:
        node.tab_bar.next_selected_tab_id = window.tab_id


def _in_window(node: Node | None) -> bool:
    """Whether what is docked there has the window behind it, not a panel that floats over others."""
    while (above := _parent_of(node)) is not None:
        node = above
    return node is not None and node.is_dock_space()


def follow(state: AppState) -> None:
    """What has nothing to show leaves its space to the other; what is asked for comes to the front."""
    panel = _docking().dockable_window_of_name
    alone, presents = state.is_model_alone, state.presenting.pane is not None
    free = not state.window.bare and not presents
    panel("3D view").is_visible = state.has_view and not alone and free
    panel("Images").is_visible = not alone and not presents
    panel(SPLATS).is_visible = alone and not presents
    panel(TUNING).is_visible = state.tuning.shown and free
    if state.tuning.asked:
        panel(TUNING).focus_window_at_next_frame = state.tuning.shown
        laid_out.came(state.tuning)
    _show(panel(EDIT), state.editing.active and free)
    _show(panel(MASKS), state.masking.active and free)
    if state.session.notes_asked:
        panel("Notes").is_visible = True
        if not state.source.asked:  # Before that, another arrangement of panels may come.
            notes_actions.notes_came(state)
    name = SPLATS if alone else "Images"
    if state.source.asked and (opened := _window(name)) is not None:
        # Of another arrangement of panels, which may bring its own to the front, it takes some frames.
        is_in_front = opened.active and not opened.hidden
        panel(name).focus_window_at_next_frame = not is_in_front
        if is_in_front:
            laid_out.came(state.source)
    if state.runs.asked:
        window = _window("Reconstruction")
        panel("Reconstruction").focus_window_at_next_frame = window is not None and window.hidden
        laid_out.came(state.runs)
    if state.reports.asked:
        # Once in front, it is as the View menu says.
        panel(REPORT).is_visible = panel(REPORT).focus_window_at_next_frame = True
        laid_out.came(state.reports)
    _bring_title_into_sight()


def _show(window: hello_imgui.DockableWindow, wanted: bool) -> None:
    """Show or hide a panel; it comes to the front when it appears."""
    window.focus_window_at_next_frame |= wanted and not window.is_visible
    window.is_visible = wanted


def _docking() -> hello_imgui.DockingParams:
    return hello_imgui.get_runner_params().docking_params


def panel(
    title: str,
    dock: str,
    draw: Callable[[], None],
    shown: Literal["always", "by the menu", "by the state"] = "always",
) -> hello_imgui.DockableWindow:
    """What the runner docks by that title."""
    made = hello_imgui.DockableWindow(title, dock, draw, shown == "always", shown == "by the menu")
    made.include_in_view_menu = shown != "by the state"
    made.remember_is_visible = shown == "by the menu"
    return made
