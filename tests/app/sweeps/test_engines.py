"""Where jobs run: real processes, killed ones, dask and submitit."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import psutil
import pytest

from app.errors import UserError
from app.sweeps.engines.engine import Engine, workers_for
from app.sweeps.engines.local import local
from app.sweeps.engines.opening import open_engine
from app.sweeps.engines.slurm import submitted_by
from app.sweeps.plan import planned, state, write_sweep
from app.sweeps.spec import Slurm, spec_of
from app.sweeps.sweep import run_jobs
from app.sweeps.worker import end_with_parent
from tests.app.conftest import ROOT

SPEC = """
clips = ["{clip}"]
task = "train"
seeds = [{seeds}]
[settings]
iterations = {iterations}
n_gaussians = 100
"""


@pytest.fixture
def sweep(tmp_path: Path, clip_path: Path) -> Path:
    """Five short trainings."""
    path = tmp_path / "sweep.toml"
    path.write_text(SPEC.format(clip=clip_path.as_posix(), seeds="0, 1, 2, 3, 4", iterations=3))
    return path


def started(sweep: Path, *flags: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "app", "sweep", str(sweep), "--out", str(sweep.parent / "out"), *flags]
    return subprocess.Popen(
        command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def results(sweep: Path) -> dict[str, dict[str, object]]:
    """Measures by job that do not depend on time."""
    timed = ("ms_per_frame", "wall_seconds", "train_seconds")
    found = {}
    for path in (sweep.parent / "out" / "jobs").glob("*/result.json"):
        measures = json.loads(path.read_text())["measures"]
        found[path.parent.name] = {name: value for name, value in measures.items() if name not in timed}
    return found


def wait_for_results(sweep: Path, count: int) -> None:
    until = time.monotonic() + 240
    while len(results(sweep)) < count:
        assert time.monotonic() < until
        time.sleep(0.1)


def test_windows_gets_no_more_workers_than_python_takes_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "win32")
    for workers, threads in ((100, 1), (None, 1), (3, 1)):
        with local(workers, threads) as engine:
            assert engine.workers == min(workers or workers_for(threads), 61)


@pytest.mark.slow
def test_killed_workers_and_a_killed_client_lose_nothing(sweep: Path) -> None:
    first = started(sweep, "--workers", "2")
    wait_for_results(sweep, 1)
    workers = [
        child for child in psutil.Process(first.pid).children() if "spawn_main" in " ".join(child.cmdline())
    ]
    assert workers
    workers[0].kill()
    wait_for_results(sweep, 2)
    workers = psutil.Process(first.pid).children()
    first.kill()
    first.communicate()
    _, alive = psutil.wait_procs(workers, timeout=20)
    assert not alive  # Workers end with the one that started them.
    done = results(sweep)
    written = {key: (sweep.parent / "out" / "jobs" / key / "result.json").stat().st_mtime_ns for key in done}
    out, error = started(sweep, "--workers", "1", "--json").communicate(timeout=240)
    assert error.count("failed") == 0
    facts = json.loads(out)
    assert facts["counts"] == {"finished": 5, "failed": 0, "left": 0}
    again = {key: (sweep.parent / "out" / "jobs" / key / "result.json").stat().st_mtime_ns for key in done}
    assert written == again  # None was done twice.
    assert len(results(sweep)) == 5


def worker() -> None:
    """As on Windows, where the number of the parent stays after its end."""
    parent = os.getppid()
    os.getppid = lambda: parent
    end_with_parent()
    sys.stdout.write(f"{os.getpid()}\n")
    sys.stdout.flush()
    time.sleep(60)


STARTS_A_WORKER = """
import multiprocessing
from tests.app.sweeps.test_engines import worker
process = multiprocessing.get_context("spawn").Process(target=worker)
process.start()
process.join()
"""


def test_a_worker_ends_with_a_killed_parent_on_every_system() -> None:
    with subprocess.Popen(
        [sys.executable, "-c", STARTS_A_WORKER], cwd=ROOT, stdout=subprocess.PIPE, text=True
    ) as parent:
        assert parent.stdout is not None
        begun = psutil.Process(int(parent.stdout.readline()))
        parent.kill()
        parent.wait()
        _, alive = psutil.wait_procs([begun], timeout=10)
        for process in alive:
            process.kill()
    assert not alive


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_ends_in_one_line_and_leaves_no_process(sweep: Path) -> None:
    running = started(sweep, "--workers", "2")
    wait_for_results(sweep, 1)
    workers = psutil.Process(running.pid).children()
    os.killpg(running.pid, signal.SIGINT)
    _, error = running.communicate(timeout=60)
    assert running.returncode == 130
    assert "jobs are finished, the same command resumes" in error.splitlines()[-1]
    assert "Traceback" not in error
    _, alive = psutil.wait_procs(workers, timeout=20)
    assert not alive
    assert (sweep.parent / "out" / "table.csv").is_file()


@pytest.mark.slow
def test_dask_and_processes_give_the_same_table(sweep: Path, tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    sweep.write_text(sweep.read_text().replace("0, 1, 2, 3, 4", "0, 1"))
    done = started(sweep, "--on", "dask", "--workers", "2")
    out, error = done.communicate(timeout=240)
    assert done.returncode == 0, error
    assert "2 finished" in out
    by_dask = results(sweep)
    (sweep.parent / "out").rename(tmp_path / "dask")
    done = started(sweep, "--workers", "1")
    done.communicate(timeout=240)
    assert results(sweep) == by_dask
    assert len(by_dask) == 2


@pytest.mark.slow
def test_submitit_runs_jobs_as_futures(tmp_path: Path, clip_path: Path) -> None:
    pytest.importorskip("submitit")
    path = tmp_path / "sweep.toml"
    text = SPEC.format(clip=clip_path.as_posix(), seeds="0, 1", iterations=2)
    path.write_text(text)
    plan = planned(spec_of(tomllib.loads(text), path), path)
    folder = tmp_path / "out"
    write_sweep(plan, folder)
    with submitted_by("local", 1, Slurm(minutes=5), folder) as executor:
        run_jobs(plan, folder, Engine("slurm", executor, 2, 2), lambda done, note: None)
    assert state(plan.jobs, folder)["finished"] == 2
    assert not list(folder.glob(".slurm-*"))


def test_places_that_are_not_there_are_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    for on, told in (("moon", "expected local, dask"), ("slurm", "found no srun")):
        with (
            pytest.raises(UserError, match=told),
            open_engine(on, workers=1, threads=1, slurm=Slurm(), folder=tmp_path),
        ):
            pass


@pytest.mark.slow
@pytest.mark.parametrize("held_out", [True, False])
def test_finished_trainings_keep_what_is_wanted_and_are_measured_on_the_right_frames(
    tmp_path: Path, clip_path: Path, held_out: bool
) -> None:
    """With the model and measured on held-out training frames alone, or with renders of test frames."""
    given = tomllib.loads(SPEC.format(clip=clip_path.as_posix(), seeds="0", iterations=2))
    given["settings"]["hold_out"] = held_out
    given |= {"models": held_out, "renders": not held_out}
    plan = planned(spec_of(given, path := tmp_path / "sweep.toml"), path)
    folder = tmp_path / "out"
    write_sweep(plan, folder)
    with open_engine("local", workers=1, threads=1, slurm=Slurm(), folder=folder) as engine:
        run_jobs(plan, folder, engine, lambda done, note: None)
    place = folder / "jobs" / plan.jobs[0].key
    run = place / "run"
    assert not list(run.glob("checkpoint-*"))
    assert (run / "model.safetensors").exists() == held_out
    assert (run / "run.json").is_file()
    rendered = list((place / "renders").glob("*.png"))
    assert len(rendered) == (0 if held_out else 2)  # Of ten frames, 1 and 9 are held out.
    told = [json.loads(line) for line in (run / "events.jsonl").read_text().splitlines()]
    last = [event for event in told if event["event"] == "Evaluated"][-1]
    measures = json.loads((place / "result.json").read_text())["measures"]
    if held_out:
        assert measures["psnr"] == last["psnr"]
    assert ("ssim" in measures) != held_out
