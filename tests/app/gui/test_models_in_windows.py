"""A model in windows in the window: its views, what can be exported, and editing."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np

from app.gui.actions import actions, camera_actions, edit_actions, export_actions
from app.gui.actions.export_offers import OFFERS
from app.gui.state.app_state import AppState
from app.gui.state.exports import What
from app.gui.work.selecting import Selector
from app.runs.run_edits import read_edits
from app.runs.run_folder import RunFolder
from app.scenes.records import SceneRecord
from renderer.editing.edits import Edits
from renderer.editing.mask import Mask
from renderer.model_windows import windows_of
from tests.app.gui.settling import keep_all
from tests.app.gui.test_edit_actions import drag, opened


def settle(state: AppState, selector: Selector) -> None:
    request = state.editing.wish
    assert request is not None
    (answer,) = selector.select(request)
    edit_actions.take_selected(state, request, answer)


def test_in_the_window_it_is_edited_as_any_other(state: AppState, windowed_run: Path, tmp_path: Path) -> None:
    run = Path(shutil.copytree(windowed_run, tmp_path / "run"))
    opened(state, run)
    assert {"motion", "surface"} <= set(camera_actions.choices(state))
    assert not export_actions.why_not_export(state, "surface of all frames")
    base, selector = state.scene.model, Selector()
    assert base is not None
    edit_actions.toggle(state)
    settle(state, selector)
    assert state.editing.limits["motion"][1] > 0
    drag(state, (0, 0), (48, 80))
    settle(state, selector)
    rows = [window.rows for window in windows_of(base.model)]
    chosen = state.editing.edits.selected.booleans()
    assert all(0 < chosen[row].mean() < 1 for row in rows)
    edit_actions.choose_how(state, "intersect")
    edit_actions.select_present(state)
    settle(state, selector)
    kept = state.editing.edits.selected.booleans()
    assert np.array_equal(kept[rows[0]], chosen[rows[0]])
    assert not kept[rows[1].start :].any()
    edit_actions.delete(state)
    shown = state.scene.model
    assert shown is not None
    assert len(shown.model) == len(base.model) - kept.sum()
    assert np.array_equal(shown.model.at(0.97).means, base.model.at(0.97).means)
    edit_actions.save(state)
    keep_all(state)
    assert not state.editing.is_unsaved
    assert read_edits(RunFolder(run), len(base.model)) == state.editing.edits


def test_what_needs_the_same_gaussians_throughout_is_of_the_window_that_is_shown(
    state: AppState, windowed_run: Path, tmp_path: Path
) -> None:
    opened(state, windowed_run)
    actions.go_to_end(state, last=True)
    whats: tuple[What, ...] = ("page for browsers", "arrays of all frames", "surface through time")
    for what in whats:
        export_actions.choose_what(state, what)
        part = export_actions.which_part(state)
        assert part.startswith("Only frames 65 to 112:")
        assert part.endswith("window 3 of 3.")
        assert export_actions.stem_of(state) == f"run-window-3-{OFFERS[what].name}"
        request = export_actions.export_request(state, what, "of-window")
        assert request is not None
        export_actions.cancelled(state)
        assert isinstance(request.record, SceneRecord)
        assert request.record.window == 3
    export_actions.choose_what(state, "splats of this moment")
    assert export_actions.which_part(state) == ""


def test_a_window_that_is_edited_away_is_not_exported(
    state: AppState, windowed_run: Path, tmp_path: Path
) -> None:
    run = Path(shutil.copytree(windowed_run, tmp_path / "run"))
    opened(state, run)
    base = state.scene.model
    assert base is not None
    rows = windows_of(base.model)[2].rows
    edit_actions.toggle(state)
    gone = Mask.of(np.arange(len(base.model)) >= rows.start)
    edits = Edits.none(len(base.model)).selecting(gone, "replace").deleting()
    state.scene.model = base.edited(edits)
    actions.go_to_end(state, last=True)
    assert "window 3" in export_actions.why_not_export(state, "page for browsers")
    actions.go_to_end(state, last=False)
    assert not export_actions.why_not_export(state, "page for browsers")
