"""Where to look from: named views, the camera path, and the files of both."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from imgui_bundle import ImVec2, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons

from app.files.legible import as_label, legible
from app.gui.actions import path_actions
from app.gui.commands.camera_commands import export_cameras, export_path, import_views
from app.gui.state.app_state import AppState
from app.gui.style.handles import slide_labelled
from app.gui.style.widgets import button, checkbox, em, explain, note, shortened
from app.scenes.scene import Scene
from renderer.camera_files import NamedCamera
from renderer.camera_path import Keyframe

IMPORT_TEXT = (
    "Saved views, cameras.json, transforms.json or COLMAP's images.txt; or drop the file on the window."
)
SAVE_TEXT = "Save all views and the path, for this app and for vesselsplat export --path."
KEY_TEXT = "I: add this view and time to the path, at its current second or after its end."
DELETE_TEXT = "Delete. Ctrl+Z undoes it."
PLAY_TEXT = "L: play or stop the path. Needs two keyframes."


def draw_cameras(state: AppState) -> None:
    if state.scene.model is None:
        note("Views and camera paths need a reconstruction: start or open one.")
        return
    _draw_files(state)
    imgui.separator_text("Views")
    imgui.set_next_item_width(-em(6))
    _, name = imgui.input_text_with_hint("##name", "name of this view", state.scene.cameras.name)
    path_actions.type_name(state, name)
    imgui.same_line()
    add, text = partial(path_actions.save_view, state), "B: add this viewpoint under this name."
    button(f"{icons.ICON_FA_PLUS} Add###keep", add, text, width=-1)
    for index, view in enumerate(state.scene.cameras.views.named):
        _draw_view(state, index, view)
    imgui.separator_text("Path")
    _draw_path(state, state.scene.model)


def _draw_files(state: AppState) -> None:
    views = state.scene.cameras.views
    button("Import…###import", partial(import_views, state), IMPORT_TEXT)
    imgui.same_line()
    some = bool(views.named or views.path.keyframes)
    button("Save###save", partial(path_actions.save_views, state), SAVE_TEXT, enabled=some)
    imgui.same_line()
    open_menu = partial(imgui.open_popup, "export")
    button("Export…###export", open_menu, "Export the poses as cameras.json for other programs.")
    with imgui_ctx.begin_popup("export") as popup:
        if popup:
            if imgui.menu_item_simple("The clip's cameras…"):
                export_cameras(state)
            if imgui.menu_item_simple("The path's cameras…", enabled=bool(views.path.keyframes)):
                export_path(state)


def _draw_view(state: AppState, index: int, one: NamedCamera) -> None:
    with imgui_ctx.push_id(f"view {index}"):
        width = imgui.get_content_region_avail().x - em(5.2)
        short, size = shortened(legible(one.name), width), ImVec2(width, imgui.get_frame_height())
        with imgui_ctx.push_style_var(imgui.StyleVar_.selectable_text_align, ImVec2(0, 0.5)):
            if imgui.selectable(f"{as_label(short)}###go", False, 0, size)[0]:
                path_actions.go_to(state, one.camera)
        explain(f"{one.name}: view the reconstruction from here.")
        imgui.same_line()
        button(f"{icons.ICON_FA_EDIT}###rename", lambda: imgui.open_popup("name"), "Rename")
        imgui.same_line()
        delete = partial(path_actions.delete_view, state, index)
        button(f"{icons.ICON_FA_TRASH}###delete", delete, DELETE_TEXT)
        with imgui_ctx.begin_popup("name") as popup:
            if popup:
                _draw_rename(state, index, one.name)


def _draw_rename(state: AppState, index: int, name: str) -> None:
    if imgui.is_window_appearing():
        imgui.set_keyboard_focus_here()
    flags = imgui.InputTextFlags_.enter_returns_true | imgui.InputTextFlags_.auto_select_all
    done, text = imgui.input_text("##text", name, flags)
    if done:
        path_actions.rename_view(state, index, text)
        imgui.close_current_popup()


def _draw_path(state: AppState, model: Scene) -> None:
    cameras, path = state.scene.cameras, state.scene.cameras.views.path
    button(f"{icons.ICON_FA_PLUS} Keyframe###keyframe", partial(path_actions.add_keyframe, state), KEY_TEXT)
    imgui.same_line()
    icon = icons.ICON_FA_PAUSE if cameras.playing else icons.ICON_FA_PLAY
    play, enabled = partial(path_actions.toggle_path, state), len(path.keyframes) > 1
    button(f"{icon}###path", play, PLAY_TEXT, enabled=enabled, width=2.2)
    imgui.same_line()
    changed, loop = checkbox("Loop", cameras.views.loop)
    explain("Repeat from the start; smooth where the last keyframe has the view of the first.")
    if changed:
        path_actions.set_loop(state, loop)
    imgui.same_line()
    changed, _ = checkbox("Show", cameras.path_shown)
    explain("Show the path in the 3D view, with a small camera at each keyframe. Also in the View menu.")
    if changed:
        path_actions.toggle_path_shown(state)
    if not path.keyframes:
        note("Move the view, add a keyframe, move again, add the next.")
        return
    if enabled:
        imgui.set_next_item_width(-em(0.1))
        moved, seconds = slide_labelled("##playhead", cameras.playhead, path.start, path.end, "%.2f s")
        if moved:
            path_actions.seek_path(state, seconds)
    _draw_keyframes(state, model)


def _draw_keyframes(state: AppState, model: Scene) -> None:
    flags = imgui.TableFlags_.sizing_stretch_same
    with imgui_ctx.begin_table("keyframes", 3, flags) as table:
        if not table:
            return
        imgui.table_setup_column("Second")
        imgui.table_setup_column("Frame")
        imgui.table_setup_column("", imgui.TableColumnFlags_.width_fixed, em(7.2))
        imgui.table_headers_row()
        for index, key in enumerate(state.scene.cameras.views.path.keyframes):
            with imgui_ctx.push_id(f"key {index}"):
                _draw_keyframe(state, model, index, key)


def _draw_keyframe(state: AppState, model: Scene, index: int, key: Keyframe) -> None:
    imgui.table_next_column()
    imgui.set_next_item_width(-em(0.1))
    changed, seconds = imgui.drag_float("##seconds", key.seconds, 0.02, 0, 3600, "%.2f s")
    explain("When the path reaches this keyframe. Drag, or Ctrl+click to type.")
    if changed:
        path_actions.move_keyframe(state, index, seconds)
    imgui.table_next_column()
    imgui.set_next_item_width(-em(0.1))
    first, last = model.start + 1, model.start + len(model.cameras)
    number, form = model.number_at(key.time), model.form(key.time)
    changed, number = imgui.drag_float("##time", number, 0.05, first, last, form)
    explain("The moment of the clip that is shown: a frame, or between two. Drag, or Ctrl+click to type.")
    if changed:
        path_actions.retime_keyframe(state, index, model.time_of(number))
    imgui.table_next_column()
    replace = partial(path_actions.replace_keyframe, state, index)
    acts: tuple[tuple[str, str, Callable[[], None]], ...] = (
        (icons.ICON_FA_EYE, "Go to it", partial(path_actions.seek_path, state, key.seconds)),
        (icons.ICON_FA_SYNC, "Set to this view and time", replace),
        (icons.ICON_FA_TRASH, DELETE_TEXT, partial(path_actions.delete_keyframe, state, index)),
    )
    for icon, text, act in acts:
        button(f"{icon}###{text}", act, text)
        imgui.same_line()
