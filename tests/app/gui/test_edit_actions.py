"""Editing as plain code: what is selected and changed, what the window then shows, and what is kept."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.gui.actions import actions, arriving, edit_actions
from app.gui.panels.editing import gone
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.gui.work.background import Failure
from app.gui.work.opening import OpenRequest, open_path
from app.gui.work.selecting import Selector
from app.gui.work.settings import Places
from app.runs.run_edits import read_edits
from app.runs.run_folder import RunFolder
from renderer.editing.edits import Edits
from renderer.editing.highlight import COLOR, OWN
from renderer.gaussians import DynamicGaussians
from renderer.splat_files import read_splats
from renderer.splat_files.inria_ply import ply_bytes
from tests.app.conftest import Cli
from tests.app.gui.conftest import make_model
from tests.app.gui.scenes import scene_of
from tests.app.gui.settling import keep_all


def opened(state: AppState, path: Path) -> None:
    (answer,) = open_path(OpenRequest(path))
    arriving.show_opened(state, path, answer)
    edit_actions.follow(state)
    state.scene.size = (96, 80)


@pytest.fixture
def splats(state: AppState, model: DynamicGaussians, tmp_path: Path) -> AppState:
    """With a file of splats open, in edit mode."""
    path = tmp_path / "sheet.ply"
    path.write_bytes(ply_bytes(model.raw))
    opened(state, path)
    edit_actions.toggle(state)
    settle(state)
    return state


def settle(state: AppState) -> None:
    """Answer what was asked for, as the worker does."""
    request = state.editing.wish
    assert request is not None
    (answer,) = Selector().select(request)
    edit_actions.take_selected(state, request, answer)


def drag(state: AppState, *points: tuple[float, float], how: str = "replace") -> None:
    for point in points:
        edit_actions.draw_on(state, point)
    edit_actions.end_stroke(state, how)  # type: ignore[arg-type]


def save(state: AppState) -> bool:
    """Whether the worker could keep the edits."""
    edit_actions.save(state)
    keep_all(state)
    return not state.editing.is_unsaved


def shown(state: AppState) -> DynamicGaussians:
    assert state.scene.model is not None
    return state.scene.model.model


def test_a_rectangle_selects_deletes_and_comes_back(splats: AppState) -> None:
    before = shown(splats)
    drag(splats, (0, 0), (48, 80))
    settle(splats)
    chosen = splats.editing.edits.selected
    camera = splats.scene.model.camera_at(0).fitted(96, 80)  # type: ignore[union-attr]
    inside = camera.project(before.means.astype(np.float64))[0][:, 0] <= 48
    np.testing.assert_array_equal(chosen.booleans(), inside)
    assert 0 < len(chosen) < len(before)
    edit_actions.delete(splats)
    np.testing.assert_array_equal(shown(splats).means, before.means[~inside])
    assert splats.editing.is_unsaved
    edit_actions.undo(splats)
    edit_actions.undo(splats)
    assert shown(splats) is before
    assert not splats.editing.is_unsaved
    edit_actions.redo(splats)
    edit_actions.redo(splats)
    assert len(shown(splats)) == np.count_nonzero(~inside)


def test_the_selection_is_coloured_for_the_eye_alone(splats: AppState) -> None:
    edit_actions.choose_tool(splats, "lasso")
    drag(splats, (0, 0), (0, 80), (48, 80), (48, 0))
    settle(splats)
    chosen = splats.editing.edits.selected.booleans()
    seen, plain = splats.view_request, splats.plain_view_request
    assert seen is not None
    assert plain is not None
    assert plain.scene.model is shown(splats)
    colors, own = seen.scene.model.at(0.5).colors, plain.scene.model.at(0.5).colors
    np.testing.assert_array_equal(colors[~chosen], own[~chosen])
    np.testing.assert_allclose(colors[chosen], OWN * own[chosen] + (1 - OWN) * np.array(COLOR), atol=1e-6)
    assert seen.unobserved  # What can be selected can be seen.
    edit_actions.toggle(splats)
    assert splats.view_request == replace(plain, unobserved=False)


def test_what_was_meant_for_a_selection_that_fails_is_not_done_to_another(splats: AppState) -> None:
    before = len(shown(splats))
    drag(splats, (0, 0), (48, 80))
    request = splats.editing.wish
    assert request is not None
    edit_actions.delete(splats)
    edit_actions.take_selected(splats, request, Failure(RuntimeError("no memory")))
    drag(splats, (48, 0), (96, 80))
    edit_actions.take_selected(splats, request, Failure(RuntimeError("no memory")))
    settle(splats)
    assert (len(shown(splats)), len(splats.editing.edits.selected) > 0) == (before, True)


@pytest.mark.parametrize("tool", ["sphere", "box"])
def test_a_click_selects_around_the_surface(splats: AppState, tool: str) -> None:
    edit_actions.choose_tool(splats, tool)  # type: ignore[arg-type]
    splats.editing.radius = 0.1
    request = splats.plain_view_request
    assert request is not None
    pixels, _ = request.camera.project(shown(splats).means.astype(np.float64))
    drag(splats, (float(pixels[0, 0]), float(pixels[0, 1])))
    settle(splats)
    few = len(splats.editing.edits.selected)
    assert splats.editing.center is not None
    splats.editing.radius = 1.0
    edit_actions.select_again(splats)
    settle(splats)
    assert 0 < few < len(splats.editing.edits.selected)
    drag(splats, (0.0, 0.0))
    settle(splats)
    assert splats.window.toast is not None


def test_what_is_asked_for_while_a_selection_is_on_its_way_comes_after_it(splats: AppState) -> None:
    drag(splats, (0, 0), (48, 80))
    edit_actions.delete(splats)
    assert splats.editing.edits == Edits.none(30)
    settle(splats)
    assert 0 < len(splats.editing.edits.deleted) < 30


def test_a_selection_asked_for_during_another_is_the_one_that_is_deleted(splats: AppState) -> None:
    edit_actions.select_range(splats, "opacity", (0.0, 1.0))
    edit_actions.select_range(splats, "depth", (0.0, 1e9))
    edit_actions.select_range(splats, "depth", (1e8, 1e9))
    edit_actions.delete(splats)
    while splats.editing.wish is not None:
        settle(splats)
    assert splats.editing.edits == Edits.none(30)
    drag(splats, (0, 0), (48, 80))
    drag(splats, (48, 0), (96, 80), how="add")
    edit_actions.undo(splats)
    edit_actions.delete(splats)
    while splats.editing.wish is not None:
        settle(splats)
    assert 0 < len(splats.editing.edits.deleted) < 30


def test_what_follows_a_selection_that_fails_is_left_up_to_the_next(splats: AppState) -> None:
    edit_actions.select_range(splats, "opacity", (0.0, 1.0))
    edit_actions.delete(splats)
    drag(splats, (0, 0), (48, 80))
    edit_actions.delete(splats)
    request = splats.editing.wish
    assert request is not None
    edit_actions.take_selected(splats, request, Failure(ValueError("broken")))
    settle(splats)
    assert 0 < len(splats.editing.edits.deleted) < 30


def test_undo_outside_edit_mode_is_of_parameters(splats: AppState) -> None:
    drag(splats, (0, 0), (48, 80))
    settle(splats)
    edit_actions.delete(splats)
    edit_actions.toggle(splats)
    edits = splats.editing.edits
    edit_actions.undo(splats)
    edit_actions.delete(splats)
    assert splats.editing.edits == edits


def test_an_edited_file_is_saved_as_another(splats: AppState, tmp_path: Path) -> None:
    source = (tmp_path / "sheet.ply").read_bytes()
    edit_actions.select_range(splats, "depth", (0.0, 1e9))
    settle(splats)
    drag(splats, (0, 0), (48, 80), how="subtract")
    settle(splats)
    edit_actions.crop(splats)
    for name in ("sheet-edited.ply", "sheet-edited-2.ply"):
        assert save(splats)
        written = read_splats(tmp_path / name).raw
        np.testing.assert_array_equal(written.means, shown(splats).means)
    assert (tmp_path / "sheet.ply").read_bytes() == source
    assert not splats.editing.is_unsaved


def test_an_edited_file_is_made_again_of_its_source(
    splats: AppState, tmp_path: Path, vesselsplat: Cli
) -> None:
    drag(splats, (0, 0), (48, 80))
    settle(splats)
    edit_actions.delete(splats)
    assert save(splats)
    call = vesselsplat("replay", tmp_path / "sheet-edited.ply")
    assert (call.code, call.error) == (0, "")


def test_unsaved_edits_are_asked_about_before_they_are_lost(splats: AppState, tmp_path: Path) -> None:
    edit_actions.select_all(splats)
    edit_actions.delete(splats)
    assert len(shown(splats)) == 0
    actions.open_path(splats, tmp_path / "other.ply")
    assert splats.source.opening is None
    edit_actions.answer(splats, "stay")
    assert splats.source.opening is None
    assert splats.editing.leaving is None
    actions.open_path(splats, tmp_path / "other.ply")
    edit_actions.answer(splats, "discard")
    assert splats.source.opening is not None
    assert len(shown(splats)) == 30


def test_what_waits_for_a_selection_is_discarded_with_the_edits(splats: AppState, tmp_path: Path) -> None:
    edit_actions.select_all(splats)
    edit_actions.hide(splats)
    drag(splats, (0, 0), (63, 47))
    edit_actions.delete(splats)
    assert splats.editing.wish is not None
    assert splats.editing.waiting
    actions.open_path(splats, tmp_path / "other.ply")
    edit_actions.answer(splats, "discard")
    assert splats.editing.wish is None
    assert not splats.editing.waiting
    assert not splats.editing.is_unsaved


def test_saving_waits_for_a_selection_and_what_was_asked_for_after_it(splats: AppState) -> None:
    drag(splats, (0, 0), (48, 80))
    edit_actions.delete(splats)
    edit_actions.save(splats)
    edit_actions.select_all(splats)
    assert splats.editing.saving is None
    settle(splats)
    assert splats.editing.saving is not None
    assert splats.editing.saving.edits.deleted == splats.editing.edits.deleted
    assert 0 < len(splats.editing.saving.edits.deleted) < splats.editing.edits.count
    keep_all(splats)
    assert not splats.editing.is_unsaved


def test_a_selection_that_fails_takes_its_changes_along_but_not_the_saving(splats: AppState) -> None:
    edit_actions.select_all(splats)
    edit_actions.hide(splats)
    drag(splats, (0, 0), (48, 80))
    edit_actions.delete(splats)
    edit_actions.save(splats)
    request = splats.editing.wish
    assert request is not None
    edit_actions.take_selected(splats, request, Failure(MemoryError()))
    assert splats.editing.saving is not None
    assert not len(splats.editing.saving.edits.deleted)
    keep_all(splats)
    assert not splats.editing.is_unsaved


def test_edits_of_a_run_come_back_with_it(
    state: AppState, runs: dict[str, Path], tmp_path: Path, places: Places
) -> None:
    folder = RunFolder(Path(shutil.copytree(runs["original"], tmp_path / "run")))
    opened(state, folder.path)
    count = len(shown(state))
    edit_actions.toggle(state)
    settle(state)
    low, high = state.editing.limits["opacity"]
    edit_actions.select_range(state, "opacity", (0.0, (low + high) / 2))
    settle(state)
    edit_actions.hide(state)
    hidden = state.editing.edits.hidden
    assert 0 < len(hidden) < count
    assert save(state)
    saved = read_edits(folder, count)
    assert saved is not None
    assert saved.hidden == hidden
    again = AppState(places)
    opened(again, folder.path)
    assert again.editing.edits.hidden == hidden
    assert not again.editing.is_unsaved
    assert len(shown(again)) == count - len(hidden)
    assert again.scene.model is not None
    assert again.scene.model.record.edits is not None
    assert again.scene.model.record.edits.n_hidden == len(hidden)
    folder.save_model(folder.model().rows(np.arange(count - 1)))
    opened(again, folder.path)
    assert again.window.banner is not None
    assert "edits of another model" in again.window.banner.message
    assert len(shown(again)) == count - 1


def test_editing_begins_anew_with_another_model(splats: AppState) -> None:
    edit_actions.select_all(splats)
    assert splats.scene.model is not None
    splats.scene.model = replace(
        scene_of(make_model(12), splats.scene.model.cameras, "live", 9), iteration=1, live=True
    )
    update(splats, Channels(), 1.0)
    assert splats.editing.base is None
    assert not splats.editing.active
    edit_actions.toggle(splats)
    assert not splats.editing.active


def test_edits_that_another_window_saved_are_told_before_they_are_replaced(
    state: AppState, places: Places, runs: dict[str, Path], tmp_path: Path
) -> None:
    folder = RunFolder(Path(shutil.copytree(runs["original"], tmp_path / "run")))
    other = AppState(places)
    halves = {}
    for window, box in ((state, ((0, 0), (40, 80))), (other, ((40, 0), (96, 80)))):
        opened(window, folder.path)
        edit_actions.toggle(window)
        settle(window)
        drag(window, *box)
        settle(window)
        edit_actions.delete(window)
        halves[id(window)] = window.editing.edits.deleted
    count = halves[id(state)].count
    assert halves[id(state)] != halves[id(other)]
    assert save(state)
    assert not save(other)
    assert other.window.banner is not None
    assert "another window" in other.window.banner.message
    saved = read_edits(folder, count)
    assert saved is not None
    assert saved.deleted == halves[id(state)]
    assert other.editing.is_unsaved
    # Asked again, it replaces them: that is what the line said.
    assert save(other)
    saved = read_edits(folder, count)
    assert saved is not None
    assert saved.deleted == halves[id(other)]
    # Its own save is no other window's.
    edit_actions.undo(other)
    assert save(other)


def test_what_is_gone_is_said_in_a_line_that_fits() -> None:
    edits = Edits.none(30_000)
    assert gone(edits) == ""
    few = edits.selecting_all().deleting()
    assert gone(few) == "30,000 deleted"
    assert gone(edits.selecting_all().hiding()) == "30,000 hidden"


def test_what_cannot_be_edited_says_why(state: AppState, model: DynamicGaussians) -> None:
    assert state.source.clip is not None
    state.scene.model = replace(scene_of(model, state.source.clip.cameras), live=True)
    edit_actions.follow(state)
    edit_actions.toggle(state)
    assert not state.editing.active
    assert state.window.toast is not None
    assert "not finished" in state.window.toast.message
