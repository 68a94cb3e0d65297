"""Processes of the program tell OpenMP how to wait before it is loaded; those of others are left alone."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import pytest

from app.__main__ import main
from app.runs.job import TrainingJob
from app.runs.train_run import TrainRequest
from app.runs.worker import Steps
from renderer.train.config import TrainConfig
from renderer.train.events import Warned
from tests.app.runs.test_job import PATIENCE

STEPS = """
import os
from pathlib import Path

from renderer.train.events import Warned


def steps(request):
    maps = Path("/proc/self/maps")
    loaded = "gomp" in maps.read_text() if maps.exists() else False
    yield Warned(f"{os.environ.get('OMP_WAIT_POLICY')}, loaded: {loaded}")
"""


@pytest.mark.parametrize(("asked", "heard"), [(None, "PASSIVE"), ("ACTIVE", "ACTIVE")])
def test_a_command_says_so_unless_the_user_has(
    asked: str | None, heard: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OMP_WAIT_POLICY", asked or "")
    if asked is None:
        monkeypatch.delenv("OMP_WAIT_POLICY")
    assert main(["--version"]) == 0
    assert os.environ["OMP_WAIT_POLICY"] == heard


def test_the_training_process_says_so_before_openmp_is_loaded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "told_steps.py").write_text(STEPS)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delenv("OMP_WAIT_POLICY")
    from told_steps import steps  # type: ignore[import-not-found]

    assert first_of(steps, tmp_path) == Warned("PASSIVE, loaded: False")
    del sys.modules["told_steps"]


def first_of(steps: Steps, folder: Path) -> object:
    """What the process says first."""
    request = TrainRequest(clip_path=folder, run_path=folder / "run", config=TrainConfig())
    job = TrainingJob(request, steps)
    job.start()
    try:
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            if events := job.poll():
                return events[0]
            time.sleep(0.01)
    finally:
        job.close()
    return None
