"""What a run and an export say they are doing, and for how long."""

from __future__ import annotations

import importlib
import shutil
import time
from dataclasses import replace
from pathlib import Path

import pytest

from app.gui.actions import closing, job_actions
from app.gui.state.app_state import AppState
from app.gui.state.pace import Pace
from app.gui.state.run_words import COMPILING, FIRST_STEP, LONG_STEP, doing, share_done
from app.gui.update.jobs import follow_job, start_due
from app.kernels.progress import Preparation, tasks
from app.runs.job import Paused, Resumed
from app.runs.train_run import TrainRequest, run_training
from assets import phantom_path
from renderer.gaussians import DynamicGaussians
from renderer.train import meter
from renderer.train.config import TrainConfig
from renderer.train.events import Finishing, Preparing, Progress, Started
from tests.app.gui.conftest import FakeJob


def tell(state: AppState, *events: object) -> str:
    job = state.runs.reconstruction.job
    assert isinstance(job, FakeJob)
    job.inbox = [*events]
    follow_job(state)
    return doing(state)


def at(step: int, left: float) -> Progress:
    return Progress(step, 2000, 0.1, 25.0, 61.0, left, 30_000)


@pytest.fixture
def going(state: AppState) -> AppState:
    job_actions.start_reconstruction(state)
    start_due(state, FakeJob)  # type: ignore[arg-type]
    return state


def test_a_run_says_what_it_is_doing_from_its_start_to_its_end(going: AppState) -> None:
    assert tell(going) == "Starting…"
    assert (
        tell(going, Preparing("reading frames", 12, 54, 3.0, 14.0))
        == "Reading frames · 12 of 54 · about 10 s left"
    )
    assert share_done(going.runs.reconstruction) == pytest.approx(12 / 54)
    late = tell(going, Preparing("finding camera and shape from motion", 14, 20, 80.0, 0.0))
    assert late == "Finding camera and shape from motion · 14 of 20 · longer than expected"
    assert tell(going, Started(0, 2000, 30, ())) == FIRST_STEP
    going.window.now += LONG_STEP + 1
    assert doing(going) == COMPILING
    assert tell(going, at(300, 240.0)) == "Iteration 300 of 2,000 · about 4 min left"
    assert tell(going, at(300, 11_160.0)) == "Iteration 300 of 2,000 · about 3 h left"
    assert share_done(going.runs.reconstruction) == pytest.approx(0.15)
    assert tell(going, Paused()) == "Paused at iteration 300 of 2,000"
    assert tell(going, Resumed(), at(2000, 12.0)) == "Iteration 2,000 of 2,000 · about 10 s left"
    held_out = Finishing("measuring held-out frames", 4.0)
    assert tell(going, held_out) == "Measuring held-out frames · a few seconds left"
    assert share_done(going.runs.reconstruction) is None


def test_what_follows_the_last_step_counts_down_and_says_when_it_takes_longer(going: AppState) -> None:
    """It tells once, as it begins, how long is left."""
    tell(going, Started(0, 2000, 30, ()), at(2000, 40.0))
    smoothing = "Smoothing hidden motion"
    assert tell(going, Finishing("smoothing hidden motion", 40.0)) == f"{smoothing} · about 40 s left"
    going.window.now += 21
    assert doing(going) == f"{smoothing} · about 20 s left"
    going.window.now += 20
    assert doing(going) == f"{smoothing} · longer than expected"
    assert tell(going, Finishing("measuring held-out frames", 12.0)).endswith("about 10 s left")
    assert tell(going, Finishing("saving the model", 0.0)) == "Saving the model…", "not late as it begins"


def test_a_run_that_resumes_counts_from_its_checkpoint_before_its_first_event(
    going: AppState, model: DynamicGaussians
) -> None:
    job = going.runs.reconstruction.job
    assert isinstance(job, FakeJob)
    job.inbox, job.model = [Started(71, 2000, 30, ())], model
    follow_job(going)
    assert going.runs.model_wish is not None
    assert going.runs.model_wish.training.iteration == 71
    assert "Continue resumes" in closing.what_is_kept(going)


def test_the_first_step_beside_the_one_time_preparation_compiles(going: AppState) -> None:
    going.window.preparation = Preparation(tasks())
    assert tell(going, Started(0, 2000, 30, ())) == COMPILING
    going.window.preparation = replace(going.window.preparation, done=len(tasks()))
    assert doing(going) == FIRST_STEP


def test_an_export_leaves_out_its_first_frame_and_says_when_it_saves() -> None:
    pace = Pace().after(0, 100.0)
    assert pace.told(61) == "Preparing the first frame"
    pace = pace.after(1, 160.0)  # A minute to compile.
    assert pace.told(61) == "1 of 61"
    assert pace.seconds_left(61) is None
    pace = pace.after(11, 165.0)
    assert pace.seconds_left(61) == pytest.approx(25.0)
    assert pace.told(61) == "11 of 61 · about 20 s left"
    assert pace.after(61, 190.0).told(61) == "Saving the file"


class OwnTime:
    """The clock of this process, which other programs on the computer do not move."""

    def perf_counter(self) -> float:
        return time.process_time()


def test_a_real_training_knows_at_half_way_when_it_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in (meter, importlib.import_module("renderer.train.trainer")):
        monkeypatch.setattr(module, "time", OwnTime())
    clip = Path(shutil.copytree(phantom_path(), tmp_path / "phantom"))
    request = TrainRequest(
        clip_path=clip, run_path=tmp_path / "run", config=TrainConfig(iterations=240, n_gaussians=8000)
    )
    told: list[tuple[float, float]] = []
    for event in run_training(request):
        if isinstance(event, Progress) and event.iteration >= 120:
            told.append((time.process_time(), event.seconds_left))
    end = time.process_time()
    moment, said = told[0]
    assert said == pytest.approx(end - moment, rel=0.3)
