"""A reconstruction edited in the whole window, by mouse and keys."""

from __future__ import annotations

import shutil
from pathlib import Path

import glfw
import pytest
from imgui_bundle import ImVec2, glfw_utils, imgui

from app.gui.actions import actions
from app.gui.commands.keys import chord
from app.gui.work.settings import Places
from app.runs.run_folder import RunFolder
from tests.app.gui.driver import Driver, wait


@pytest.mark.display
def test_select_delete_undo_save_and_reopen(places: Places, runs: dict[str, Path], tmp_path: Path) -> None:
    """Editing by mouse and keys, as a person does it."""
    folder = RunFolder(Path(shutil.copytree(runs["original"], tmp_path / "run")))
    count = len(folder.model())
    driver = Driver(places, opens=folder.path)
    state = driver.state

    def drag_across_left_half(ctx: imgui.test_engine.TestContext) -> None:
        box = ctx.item_info("//3D view/view").rect_full
        ctx.mouse_move_to_pos(ImVec2(box.min.x + 4, box.min.y + 4))
        ctx.mouse_down()
        ctx.mouse_move_to_pos(ImVec2((box.min.x + box.max.x) / 2, box.max.y - 4))
        ctx.mouse_up()
        wait(ctx, lambda: state.editing.wish is None and not state.editing.stroke, "the selection")

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: state.scene.view is not None, "the view")
        ctx.key_press(chord("Ctrl+E"))
        wait(ctx, lambda: state.editing.active and state.editing.wish is None, "edit mode")
        ctx.yield_(3)
        drag_across_left_half(ctx)
        chosen = len(state.editing.edits.selected)
        assert 0 < chosen < count
        ctx.key_press(imgui.Key.delete)
        wait(ctx, lambda: len(state.editing.edits.deleted) == chosen, "deletion")
        ctx.key_press(chord("Ctrl+Z"))
        wait(ctx, lambda: not state.editing.is_unsaved, "undo")
        ctx.key_press(chord("Ctrl+Y"))
        wait(ctx, lambda: state.editing.is_unsaved, "redo")
        actions.open_path(state, folder.path)
        ctx.yield_(3)
        ctx.item_click("//Unsaved edits/Stay")
        assert state.source.opening is None
        glfw.set_window_should_close(glfw_utils.glfw_window_hello_imgui(), 1)
        wait(ctx, lambda: state.editing.leaving is not None, "the question before quitting")
        ctx.yield_(3)
        ctx.item_click("//Unsaved edits/Stay")
        ctx.item_click("//Edit/###edit Save")
        wait(ctx, lambda: not state.editing.is_unsaved, "the saved edits")
        actions.open_path(state, folder.path)
        wait(ctx, lambda: state.source.opening is None and not state.editing.active, "the run again")
        ctx.yield_(2)
        assert len(state.editing.edits.deleted) == chosen
        assert state.scene.model is not None
        assert len(state.scene.model.model) == count - chosen

    driver.run(drive)
    assert len(folder.model()) == count
    assert folder.edits_path.is_file()
