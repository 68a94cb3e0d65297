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


def test_each_export_is_of_the_whole_clip(state: AppState, windowed_run: Path) -> None:
    opened(state, windowed_run)
    actions.go_to_end(state, last=True)
    whats: tuple[What, ...] = (
        "page for browsers", "arrays of all frames", "surface through time", "splats through time",
    )  # fmt: skip
    for what in whats:
        export_actions.choose_what(state, what)
        assert not export_actions.why_not_export(state, what)
        assert export_actions.stem_of(state) == f"run-{OFFERS[what].name}"
        request = export_actions.export_request(state, what, "whole")
        assert request is not None
        export_actions.cancelled(state)
        assert isinstance(request.record, SceneRecord)
        assert request.record.window is None
