"""A sweep in the window: opened by its folder, one point a job, an image and settings to take."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.errors import UserError
from app.files.image_files import write_image
from app.gui.actions import arriving, history_actions, sweep_actions
from app.gui.panels.report import draw_report
from app.gui.state.app_state import AppState
from app.gui.work.background import Failure
from app.gui.work.opening import OpenRequest, open_path
from app.gui.work.swept import Swept, in_words, read_swept_image
from app.sweeps.jobs import PICTURE, Job, JobFolder
from app.sweeps.plan import Plan, write_sweep
from app.sweeps.spec import all_settings, spec_of
from enhance.vessel import VesselParams
from tests.app.gui.ui import Shown, Ui

GIVEN = {
    "clips": ["a.png"],
    "task": "enhance",
    "settings": {"pixels": "all"},
    "variants": [{"method": "vessel", "strength": 1.5}, {"method": "clahe"}],
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A sweep of two jobs, the second without an image."""
    spec = spec_of(GIVEN, tmp_path / "sweep.toml")
    jobs = tuple(Job("enhance", "a.png", "5" * 64, one, 8) for one in all_settings(spec))
    write_sweep(Plan(spec, jobs, {}), tmp_path / "out")
    for place, job in enumerate(jobs):
        kept = JobFolder.of(tmp_path / "out", job.key)
        measures = {"vessel_contrast": 0.4 + place, "noise_gain": 1.0 + place, "dv": 3.0, "bv": None}
        kept.finish(job, {"measures": measures, "seconds": 2.0 + place})
    first = JobFolder.of(tmp_path / "out", jobs[0].key).path
    write_image(first / PICTURE, np.full((12, 16, 3), 77, np.uint8), {})
    return tmp_path / "out"


def opened(state: AppState, folder: Path) -> Swept:
    (found,) = open_path(OpenRequest(folder))
    arriving.show_opened(state, folder, found)
    assert state.reports.asked
    assert state.reports.shown is not None
    assert state.reports.shown.sweep is not None
    return state.reports.shown.sweep


def test_the_folder_and_its_file_open_as_jobs_and_tables(state: AppState, folder: Path) -> None:
    clip = state.source.clip
    for path in (folder, folder / "sweep.json"):
        sweep = opened(state, path)
        assert state.source.clip is clip  # It joins what is open.
        assert state.reports.shown is not None
        assert state.reports.shown.about == "out: 2 of 2 jobs finished, 1 clip"
        assert [job.setting for job in sweep.jobs] == ["method vessel, strength 1.5", "method clahe"]
        assert set(sweep.series) == {"method vessel", "method clahe"}
        assert sweep.columns[:2] == ("vessel_contrast", "noise_gain")
        assert sweep.first == ("noise_gain", "vessel_contrast")
        across, up = sweep.places("method clahe", "noise_gain", "vessel_contrast")
        assert (across.tolist(), up.tolist()) == ([2.0], [1.4])
        assert np.isnan(sweep.places("method clahe", "seconds", "bv")[1]).all()


def test_a_setting_and_a_measure_of_one_name_are_two_axes(state: AppState, tmp_path: Path) -> None:
    given = {"clips": ["a"], "task": "train", "grid": {"n_gaussians": [8000, 30000]}}
    spec = spec_of(given, tmp_path / "sweep.toml")
    jobs = tuple(Job("train", "a", "5" * 64, one, 8) for one in all_settings(spec))
    write_sweep(Plan(spec, jobs, {}), tmp_path / "out")
    for job, count in zip(jobs, (7312.0, 21544.0), strict=True):
        kept = JobFolder.of(tmp_path / "out", job.key)
        kept.finish(job, {"measures": {"psnr": 30.0, "n_gaussians": count}, "seconds": 1.0})
    sweep = opened(state, tmp_path / "out")
    assert [job.setting for job in sweep.jobs] == ["n gaussians 8000, seed 0", "n gaussians 30000, seed 0"]
    (series,) = sweep.series
    across, up = sweep.places(series, "n_gaussians", "measured_n_gaussians")
    assert (across.tolist(), up.tolist()) == ([8000, 30000], [7312, 21544])


def test_settings_of_a_job_are_those_that_it_was_done_with(state: AppState, folder: Path) -> None:
    first, second = opened(state, folder).jobs
    assert first.params == VesselParams(strength=1.5)
    assert second.params is None
    before = state.chosen
    state.enhancement.scope = "clip"
    sweep_actions.use_params(state, first)
    assert state.enhancement.params == VesselParams(strength=1.5)
    assert (state.enhancement.scope, state.enhancement.pixels) == ("automatic", "all")
    history_actions.undo(state)
    assert state.chosen == replace(before, scope="clip")
    sweep_actions.use_params(state, first)
    assert state.enhancement.active


def test_a_click_on_a_point_shows_its_image(state: AppState, folder: Path) -> None:
    sweep = opened(state, folder)
    ui, shown = Ui(), Shown()

    def draw() -> None:
        draw_report(state, shown)

    for _ in range(4):
        ui.frame(draw)
    for x, y in ((x, y) for y in range(80, 420, 7) for x in range(60, 700, 7)):
        ui.io.add_mouse_pos_event(x, y)
        ui.io.add_mouse_button_event(0, True)
        ui.frame(draw)
        ui.io.add_mouse_button_event(0, False)
        ui.frame(draw)
        if state.reports.job is sweep.jobs[0]:
            break
    assert state.reports.job is sweep.jobs[0]
    (image,) = read_swept_image(sweep.jobs[0])
    sweep_actions.take_image(state, sweep.jobs[0], image)
    ui.frame(draw)
    ui.close()
    assert np.array_equal(shown.images["sweep job"], np.full((12, 16, 3), 77, np.uint8))


def test_an_image_that_is_not_there_is_noted_and_that_of_another_job_is_not_taken(
    state: AppState, folder: Path
) -> None:
    first, second = opened(state, folder).jobs
    sweep_actions.choose_job(state, second)
    with pytest.raises(UserError, match=PICTURE):
        list(read_swept_image(second))
    sweep_actions.take_image(state, second, Failure(UserError("gone")))
    (image,) = read_swept_image(first)
    sweep_actions.take_image(state, first, image)
    assert state.reports.image is None


def test_names_are_words_of_the_field() -> None:
    assert [in_words(name) for name in ("dv_bv", "color_difference", "psnr_seldom")] == [
        "DV/BV",
        "colour difference",
        "PSNR seldom",
    ]
    # What the slider "Colour" shows are not the numbers of d_factor.
    assert [in_words(name) for name in ("d_factor", "lift", "radius")] == [
        "d factor (Colour)",
        "lift (Brightening)",
        "radius",
    ]
