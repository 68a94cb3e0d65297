"""Runs that are cut short: killed, cancelled or ended by a signal, and what goes on from there."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Generator
from dataclasses import replace
from pathlib import Path

import pytest

from app.errors import UserError
from app.runs.job import TrainingJob
from app.runs.run_folder import RunFolder
from app.runs.train_run import TrainRequest, run_training
from enhance import VesselParams
from renderer.readers.clip_options import ClipOptions
from renderer.train.checkpoint import checkpoint_paths
from renderer.train.events import Finished, Planned, Progress, Started, TrainEvent
from tests.app.conftest import CONFIG, Cli, request_of
from tests.app.runs.test_job import events_until, is_a

ROOT = Path(__file__).resolve().parents[3]

KILLED = """
import sys
from pathlib import Path
from app.runs.train_run import TrainRequest, run_training
from renderer.train.config import TrainConfig

clip, run = map(Path, sys.argv[1:])
config = TrainConfig(iterations=400, n_gaussians=600, checkpoint_every=10)
for event in run_training(TrainRequest(clip_path=clip, run_path=run, config=config)):
    pass
"""


def test_a_killed_run_goes_on_to_the_same_model(clip_path: Path, tmp_path: Path) -> None:
    config = replace(CONFIG, iterations=400)
    killed, whole = RunFolder(tmp_path / "killed"), RunFolder(tmp_path / "whole")
    process = subprocess.Popen(
        [sys.executable, "-c", KILLED, str(clip_path), str(killed.path)],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    while not list(killed.path.glob("checkpoint-*.safetensors")):
        assert process.poll() is None
        time.sleep(0.002)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert not killed.is_finished
    with pytest.raises(UserError, match="--resume"):
        list(run_training(request_of(clip_path, killed.path, config=config)))
    resumed = list(run_training(request_of(clip_path, killed.path, config=config, resume=True)))
    planned, started, finished = *resumed[:2], resumed[-1]
    assert isinstance(planned, Planned)
    assert isinstance(started, Started)
    assert isinstance(finished, Finished)
    assert 0 < started.iteration < 400
    list(run_training(request_of(clip_path, whole.path, config=config)))
    assert killed.model_path.read_bytes() == whole.model_path.read_bytes()


@pytest.mark.parametrize("is_windowed", [False, True])
def test_a_run_killed_once_its_model_is_written_tells_what_it_took(
    runs: dict[str, Path], windowed_run: Path, tmp_path: Path, is_windowed: bool
) -> None:
    finished_run = windowed_run if is_windowed else runs["original"]
    run = RunFolder(Path(shutil.copytree(finished_run, tmp_path / "run")))
    clip, config = Path(run.record().clip.path), run.record().config
    (ended,) = run_training(request_of(clip, run.path, config=config, resume=True))
    lines = run.events_path.read_text().splitlines(keepends=True)
    assert isinstance(ended, Finished)
    assert json.loads(lines[-1])["event"] == "Finished"
    omitted, memory = run.omitted(), json.loads(lines[-1])["peak_memory_mb"]
    run.events_path.write_text("".join(lines[:-1]))
    (finished,) = run_training(request_of(clip, run.path, config=config, resume=True))
    assert isinstance(finished, Finished)
    assert (finished.iteration, finished.seconds) == (ended.iteration, ended.seconds)
    assert (finished.iteration > config.iterations) == is_windowed
    assert 0 < (finished.wall_seconds or 0) <= (ended.wall_seconds or 0)
    assert run.omitted() == omitted
    # Writing the model may have taken more.
    assert memory / 2 < run.events("Finished")[-1]["peak_memory_mb"] <= memory


def test_half_a_line_of_a_killed_run_is_passed_over(tmp_path: Path) -> None:
    run = RunFolder(tmp_path)
    run.log(Started(0, 5, 3, ()))
    with run.events_path.open("a") as file:
        file.write('{"event": "Progr')
    run.log(Started(2, 5, 3, ()))
    assert [event["iteration"] for event in run.events()] == [0, 2]


def test_the_job_trains_a_real_run_and_cancel_leaves_it_to_be_resumed(
    clip_path: Path, tmp_path: Path
) -> None:
    run = RunFolder(tmp_path / "run")
    config = replace(CONFIG, iterations=50_000)
    job = TrainingJob(request_of(clip_path, run.path, config=config))
    job.start()
    try:
        events_until(job, is_a(Started))
        while not list(run.path.glob("checkpoint-*.safetensors")):
            time.sleep(0.01)
        job.cancel()
        deadline = time.monotonic() + 20
        while job.state == "running" and time.monotonic() < deadline:
            job.poll()
            time.sleep(0.01)
        assert job.state == "cancelled"
    finally:
        job.close()
    steps = run_training(request_of(clip_path, run.path, config=config, resume=True))
    started = next(event for event in steps if not isinstance(event, Planned))
    steps.close()
    assert isinstance(started, Started)
    assert started.iteration > 0


def test_a_run_resumes_with_its_own_settings_and_no_others(
    clip_path: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    config = replace(CONFIG, iterations=60, seed=3, keep=("harmonics",))
    request = request_of(clip_path, tmp_path / "run", config=config, input="enhanced")
    steps = run_training(replace(request, clip_options=ClipOptions(bottom_rows=2)))
    next(event for event in steps if isinstance(event, Progress))
    steps.close()
    again = ("train", clip_path, "--run", tmp_path / "run", "--resume")
    for flags, said in (
        (("--iterations", 50), "expected the run's iterations 60, got 50"),
        (("--bottom-rows", 3), "expected the run's bottom_rows 2, got 3"),
        (("--input", "original"), "expected the run's input enhanced, got original"),
    ):
        other = vesselsplat(*again, *flags)
        assert (other.code, f"cannot resume: {said}" in other.error) == (2, True)
    call = vesselsplat(*again, "--seed", 3, "--json")
    assert call.code == 0, call.error
    assert "finished already" not in call.error
    told = json.loads(call.out)
    assert (told["iterations"], told["input"], told["config"]["keep"]) == (60, "enhanced", ["harmonics"])
    done = vesselsplat(*again)
    assert (done.code, "the run is finished already, there is nothing left to train" in done.error) == (
        0,
        True,
    )


def test_interrupted_training_says_what_is_kept(
    clip_path: Path, tmp_path: Path, vesselsplat: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(request: TrainRequest) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("app.commands.train.run_training", interrupted)
    call = vesselsplat("train", clip_path, "--run", tmp_path / "run")
    assert (call.code, call.error.count("\n")) == (130, 1)
    assert "nothing is kept yet, the same command starts over" in call.error
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "run.json").touch()
    call = vesselsplat("train", clip_path, "--run", tmp_path / "run")
    assert "no checkpoint" in call.error
    (tmp_path / "run" / "checkpoint-0000010.safetensors").touch()
    call = vesselsplat("train", clip_path, "--run", tmp_path / "run")
    assert (call.code, call.error.count("\n")) == (130, 1)
    assert "is kept, --resume continues from it" in call.error


def test_a_signal_while_steps_are_taken_keeps_those_that_are_done(
    clip_path: Path, tmp_path: Path, vesselsplat: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    progressed: list[int] = []

    def signalled(request: TrainRequest) -> Generator[TrainEvent, None, None]:
        for event in run_training(request):
            if isinstance(event, Progress):
                progressed.append(event.iteration)
                signal.raise_signal(signal.SIGINT)
            yield event

    monkeypatch.setattr("app.commands.train.run_training", signalled)
    run = RunFolder(tmp_path / "run")
    call = vesselsplat("train", clip_path, "--run", run.path, "--iterations", 50_000)
    assert call.code == 130
    assert len(progressed) == 1
    assert [path.name for path in checkpoint_paths(run.path)] == [
        f"checkpoint-{progressed[0]:07d}.safetensors"
    ]
    assert "--resume continues from it" in call.error


@pytest.mark.parametrize(
    ("since", "told"),
    [
        ("most_exposure", "bright_level"),
        ("least_redness", "redness"),
        ("color_smoothing", "color_noise"),
        ("spare_grey", None),
    ],
)
def test_a_run_that_began_before_a_parameter_was_there_resumes(
    since: str, told: str | None, clip_path: Path, tmp_path: Path
) -> None:
    run = RunFolder(tmp_path / "run")
    asked = request_of(clip_path, run.path, config=replace(CONFIG, iterations=60), input="enhanced")
    request = replace(asked, enhance_params=VesselParams(spare_grey=0.0))  # As all did before it was there.
    steps = run_training(request)
    next(event for event in steps if isinstance(event, Progress))
    steps.close()
    record = json.loads((run.path / "run.json").read_text())
    del record["enhancement"]["params"][since]
    if told is not None:
        del record["enhancement"]["statistics"][told]
    (run.path / "run.json").write_text(json.dumps(record))
    again = replace(request, resume=True, enhance_params=VesselParams())
    with pytest.raises(UserError, match="the run's lift"):
        list(run_training(replace(again, enhance_params=VesselParams(lift=0.5))))
    *_, finished = run_training(again)
    assert isinstance(finished, Finished)


def test_a_run_that_began_when_grey_was_spared_by_1_at_most_resumes(clip_path: Path, tmp_path: Path) -> None:
    run = RunFolder(tmp_path / "run")
    asked = request_of(clip_path, run.path, config=replace(CONFIG, iterations=60), input="enhanced")
    steps = run_training(replace(asked, enhance_params=VesselParams(spare_grey=1.0)))
    next(event for event in steps if isinstance(event, Progress))
    steps.close()
    again = replace(asked, resume=True, enhance_params=VesselParams())
    with pytest.raises(UserError, match="the run's spare_grey"):
        list(run_training(replace(again, enhance_params=VesselParams(spare_grey=0.5))))
    *_, finished = run_training(again)
    assert isinstance(finished, Finished)
    assert json.loads((run.path / "run.json").read_text())["enhancement"]["params"]["spare_grey"] == 1.0
