"""Times that no calendar has, as other systems and damaged files tell them: the window goes on."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

import pytest

from app.files.legible import to_minute
from app.gui.actions.browse_actions import dated
from app.gui.panels import runs
from app.gui.state.app_state import AppState
from app.gui.work.listing import Entry
from app.gui.work.runs import FoundRuns, ListedRun
from app.runs.progress_log import TrainingLog
from app.runs.train_run import TrainRequest
from renderer.train.config import TrainConfig
from tests.app.gui.ui import Ui


@pytest.mark.parametrize("modified", [1e12, -1e12, 1e20, float("nan")])
def test_of_files_in_the_dialog(modified: float) -> None:
    assert dated(Entry(Path("a.png"), "file", modified)) == ""
    assert dated(Entry(Path("a.png"), "file", 1e9)) == to_minute(datetime.fromtimestamp(1e9))


@pytest.mark.parametrize("created", ["0001-01-01T00:00:00+14:00", "9999-12-31T23:59:00-14:00", "some day"])
def test_of_runs(ui: Ui, state: AppState, created: str) -> None:
    state.runs.is_listed = True
    wanted, clip = state.runs_request, state.source.clip
    assert wanted is not None
    assert clip is not None
    request = TrainRequest(clip_path=clip.path, run_path=state.places.runs / "run", config=TrainConfig())
    run = ListedRun(request.run_path, created, request, "finished", False, 12, 31.5, TrainingLog())
    state.runs.found = FoundRuns(wanted, (run,), 1)
    ui.frame(lambda: runs.draw_runs(state))
