"""Renders and models that are asked for after their trainings were finished."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from app.sweeps.engines.engine import Engine
from app.sweeps.jobs import PICTURE, RENDERS, RESULT, RUN, JobFolder
from app.sweeps.keeping import not_kept, to_render
from app.sweeps.plan import Plan, planned, state, write_sweep
from app.sweeps.spec import spec_of
from app.sweeps.sweep import run_jobs


def swept(clip: Path, folder: Path, **given: object) -> Plan:
    """One short training, in this process, unless it is done; what is asked for beside."""
    asked = {
        "clips": [str(clip)],
        "task": "train",
        "settings": {"iterations": 3, "n_gaussians": 100},
    }
    plan = planned(spec_of(asked | given, path := folder / "sweep.toml"), path)
    write_sweep(plan, folder)
    with ThreadPoolExecutor(1) as here:
        run_jobs(plan, folder, Engine("here", here, 1, 1), lambda done, note: None)
    assert state(plan.jobs, folder)["finished"] == 1
    return plan


def test_renders_asked_for_later_are_drawn_without_another_training(clip_path: Path, tmp_path: Path) -> None:
    before = swept(clip_path, tmp_path)
    place = JobFolder.of(tmp_path, before.jobs[0].key).path
    result, model = ((place / name).stat().st_mtime_ns for name in (RESULT, f"{RUN}/model.safetensors"))
    assert not (place / RENDERS).exists()
    plan = swept(clip_path, tmp_path, renders=True)
    assert plan.jobs == before.jobs
    drawn = sorted(path.name for path in (place / RENDERS).iterdir())
    assert drawn == ["frame-000001.png", "frame-000009.png"]
    assert result == (place / RESULT).stat().st_mtime_ns
    assert model == (place / RUN / "model.safetensors").stat().st_mtime_ns
    assert to_render(plan, tmp_path) == list(not_kept(plan, tmp_path)) == []
    # As they are where they are asked for from the start.
    other = swept(clip_path, tmp_path / "other", renders=True)
    again = JobFolder.of(tmp_path / "other", other.jobs[0].key).path / RENDERS
    assert sorted(path.name for path in again.iterdir()) == drawn
    assert (place / PICTURE).is_file()


def test_what_cannot_be_had_without_another_training_is_told(clip_path: Path, tmp_path: Path) -> None:
    swept(clip_path, tmp_path, models=False)
    plan = swept(clip_path, tmp_path, models=True, renders=True)
    assert to_render(plan, tmp_path) == []
    (told,) = not_kept(plan, tmp_path)
    assert told.startswith("no model was kept of 1 of 1 jobs: for their renders or models, remove")
    assert plan.jobs[0].key in told
    # Not where nobody asks for them.
    assert list(not_kept(swept(clip_path, tmp_path, models=False), tmp_path)) == []


def test_renders_that_fail_are_told_and_leave_the_job_finished(clip_path: Path, tmp_path: Path) -> None:
    key = swept(clip_path, tmp_path).jobs[0].key
    (JobFolder.of(tmp_path, key).path / RUN / "model.safetensors").write_bytes(b"damaged")
    plan = swept(clip_path, tmp_path, renders=True)
    (told,) = not_kept(plan, tmp_path)
    assert told.startswith("no renders of 1 of 1 jobs: ")
    assert "not drawn yet" not in told
    assert not (JobFolder.of(tmp_path, key).path / RENDERS).exists()


def test_images_and_trainings_that_hold_out_frames_have_no_renders(clip_path: Path, tmp_path: Path) -> None:
    held = {"iterations": 3, "n_gaussians": 100, "hold_out": True}
    plan = swept(clip_path, tmp_path, renders=True, settings=held)
    assert to_render(plan, tmp_path) == list(not_kept(plan, tmp_path)) == []
