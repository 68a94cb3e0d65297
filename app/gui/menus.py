"""The menu bar and the status bar."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from imgui_bundle import hello_imgui, imgui, imgui_ctx

from app.gui import (
    actions,
    camera_actions,
    comparing,
    edit_actions,
    export_actions,
    path_actions,
    theme,
    tuning_actions,
)
from app.gui.comparison import MODES, SLOTS
from app.gui.keys import TOOL_KEYS, Commands, fit_pictures, one_to_one, save_edits, toggle_help
from app.gui.legible import legible
from app.gui.panels.overlays import LONG_NOTICE
from app.gui.panels.view3d import Asks, draw_second_items
from app.gui.panels.welcome import Openers
from app.gui.state import AppState
from app.gui.widgets import em, explain

Act = Callable[[], None]


def draw_menus(
    state: AppState, openers: Openers, commands: Commands, import_views: Act, ask_second: Asks
) -> None:
    """Everything that has a key, for those who look rather than remember."""
    with imgui_ctx.begin_menu("File") as menu:
        if menu:
            _draw_file(state, openers, commands)
    with imgui_ctx.begin_menu("Picture") as menu:
        if menu:
            _draw_picture(state)
    with imgui_ctx.begin_menu("Camera") as menu:
        if menu:
            _draw_camera(state, import_views, ask_second)
    with imgui_ctx.begin_menu("Edit") as menu:
        if menu:
            _draw_edit(state)
    hello_imgui.show_view_menu(hello_imgui.get_runner_params())
    with imgui_ctx.begin_menu("Help") as menu:
        if menu:
            _item("Keys and mouse", "?", lambda: toggle_help(state))


def _item(label: str, keys: str, act: Act, *, ticked: bool = False, enabled: bool = True) -> None:
    if imgui.menu_item_simple(label, keys, ticked, enabled):
        act()


def _draw_file(state: AppState, openers: Openers, commands: Commands) -> None:
    _item("Open folder…", "Ctrl+O", openers.folder)
    _item("Open image, video, session or report…", "Ctrl+I", openers.file)
    _item("Open the built-in phantom", "", openers.phantom)
    with imgui_ctx.begin_menu("Open recent", bool(state.settings.recent)) as menu:
        if menu:
            for place, text in enumerate(state.settings.recent):
                _item(
                    f"{legible(Path(text).name)}##{place}", "", partial(actions.open_path, state, Path(text))
                )
                explain(text)
    remember = state.settings.remember_recent
    _item("Remember recent", "", lambda: actions.remember_recent(state, not remember), ticked=remember)
    imgui.separator()
    something = state.pictures is not None or state.model is not None
    _item("Save picture", "S", commands.screenshot, enabled=something)
    _item("Export…", "Ctrl+Shift+E", lambda: export_actions.toggle_export(state), enabled=something)
    _item("Save session", "Ctrl+S", commands.session, enabled=state.opened_path is not None)
    explain("What is open, its settings, views and notes; opened again like a clip.")
    imgui.separator()
    _item("Quit", "Ctrl+Q", quit_app)


def _draw_picture(state: AppState) -> None:
    clip = state.clip is not None
    _item("Enhancement", "E", lambda: actions.toggle_enhancement(state), ticked=state.enhancing, enabled=clip)
    _item("Plain white light", "Esc", lambda: actions.white_light(state), enabled=clip)
    frozen = state.frozen_index is not None
    _item("Freeze", "F", lambda: actions.toggle_freeze(state), ticked=frozen, enabled=clip)
    imgui.separator()
    _draw_compare(state, clip)
    imgui.separator()
    _item("Fit", "0", lambda: fit_pictures(state), enabled=clip)
    _item("1:1", "1", lambda: one_to_one(state), enabled=clip)
    imgui.separator()
    _item("Undo", "Ctrl+Z", lambda: actions.undo(state), enabled=len(state.past) > 1)
    _item("Redo", "Ctrl+Y", lambda: actions.redo(state), enabled=bool(state.future))
    _item("Reset all parameters", "R", lambda: actions.reset_params(state))
    imgui.separator()
    shown = state.tuning.shown
    _item("Tuning grid", "Ctrl+T", lambda: tuning_actions.toggle_tuning(state), ticked=shown)


def _draw_compare(state: AppState, clip: bool) -> None:
    for mode, key in zip(MODES, ("V", "W", "T", "D"), strict=True):
        act = (
            partial(comparing.flip, state) if mode == "flip" else partial(comparing.choose_mode, state, mode)
        )
        _item(mode.capitalize(), key, act, ticked=state.comparison.mode == mode, enabled=clip)
    _item("Swap left and right", "X", lambda: comparing.swap(state), enabled=clip)
    _item("Original left, enhanced right", "", lambda: comparing.reset_sources(state), enabled=clip)
    zebra = state.comparison.zebra
    _item("Stripes on clipped pixels", "Z", lambda: comparing.toggle_zebra(state), ticked=zebra)
    imgui.separator()
    for slot in SLOTS:
        _item(f"Store setting {slot}", f"Shift+{slot}", partial(comparing.store, state, slot))
        _item(f"Use setting {slot}", "", partial(comparing.recall, state, slot), enabled=slot in state.stored)


def _draw_camera(state: AppState, import_views: Act, ask_second: Asks) -> None:
    model, views = state.model is not None, state.cameras.views
    keys = len(views.path.keyframes)
    _item("Clip camera", "Home", lambda: camera_actions.reset_view(state), enabled=model)
    snapped, flying = state.viewer.snapped, state.viewer.flying
    snap = partial(camera_actions.toggle_snap, state)
    _item("Under its photo", "C", snap, ticked=snapped, enabled=state.has_photos)
    measuring = state.viewer.measuring
    measure = partial(camera_actions.toggle_measuring, state)
    _item("Measure", "M", measure, ticked=measuring, enabled=model)
    _item("Fly", "G", lambda: camera_actions.toggle_flight(state), ticked=flying, enabled=model)
    imgui.separator()
    _item("Keep this view", "B", lambda: path_actions.save_view(state), enabled=model)
    _item("Add a keyframe", "I", lambda: path_actions.add_keyframe(state), enabled=model)
    play = partial(path_actions.toggle_path, state)
    _item("Play the path", "L", play, ticked=state.cameras.playing, enabled=keys > 1)
    imgui.separator()
    _item("Import views…", "", import_views, enabled=model)
    some = bool(keys or views.named)
    _item("Save views and path", "", lambda: path_actions.save_views(state), enabled=some)
    _item("Export the clip's cameras", "", lambda: path_actions.export_clip_cameras(state), enabled=model)
    export = partial(path_actions.export_path_cameras, state)
    _item("Export the path's cameras", "", export, enabled=keys > 0)
    imgui.separator()
    with imgui_ctx.begin_menu("Second view", model) as menu:
        if menu:
            draw_second_items(state, ask_second)


def _draw_edit(state: AppState) -> None:
    editing = state.editing
    on, some = editing.active, editing.active and len(editing.edits.selected) > 0
    ready = editing.base is not None
    _item("Edit mode", "Ctrl+E", lambda: edit_actions.toggle(state), ticked=on, enabled=ready)
    with imgui_ctx.begin_menu("Tool", on) as menu:
        if menu:
            for tool, keys in TOOL_KEYS.items():
                choose = partial(edit_actions.choose_tool, state, tool)
                _item(tool.capitalize(), keys, choose, ticked=tool == editing.tool)
    imgui.separator()
    _item("Select all", "Ctrl+A", lambda: edit_actions.select_all(state), enabled=on)
    _item("Select none", "Ctrl+D", lambda: edit_actions.select_none(state), enabled=some)
    _item("Invert selection", "Ctrl+Shift+I", lambda: edit_actions.invert(state), enabled=on)
    imgui.separator()
    _item("Delete", "Del", lambda: edit_actions.delete(state), enabled=some)
    _item("Crop to selection", "Shift+Del", lambda: edit_actions.crop(state), enabled=some)
    _item("Hide", "H", lambda: edit_actions.hide(state), enabled=some)
    _item("Show hidden", "Shift+H", lambda: edit_actions.show_hidden(state), enabled=on)
    imgui.separator()
    _item("Undo edit", "Ctrl+Z", lambda: edit_actions.undo(state), enabled=on and bool(editing.history.past))
    _item(
        "Redo edit", "Ctrl+Y", lambda: edit_actions.redo(state), enabled=on and bool(editing.history.future)
    )
    _item("Save edits", "Ctrl+Shift+S", lambda: save_edits(state), enabled=editing.is_unsaved)


def quit_app() -> None:
    hello_imgui.get_runner_params().app_shall_exit = True


def draw_status(state: AppState) -> None:
    """The notice on the left, always; what is open and how fast things are on the right."""
    imgui.text_colored(theme.WARNING, LONG_NOTICE)
    text = "   ·   ".join(_facts(state))
    x = imgui.get_window_width() - imgui.calc_text_size(text).x - em(1)
    if x > imgui.calc_text_size(LONG_NOTICE).x + em(3):
        imgui.same_line(x)
        imgui.text_colored(theme.MUTED, text)
        if state.model is not None:
            explain(state.drawn_by)


def _facts(state: AppState) -> list[str]:
    facts = []
    if state.clip is not None:
        width, height = state.clip.size
        facts.append(f"{legible(state.clip.name)}  {width}×{height}")
    if state.pictures is not None and state.pictures.enhanced is not None:
        facts.append(f"enhanced in {state.pictures.milliseconds:.0f} ms")
    if state.model is not None:
        who = "by the processor" if state.processor_draws else "by OpenGL"
        took = f" in {state.view.milliseconds:.0f} ms" if state.view and state.processor_draws else ""
        facts.append(f"3D drawn {who}{took}")
    return facts
