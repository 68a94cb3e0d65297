"""Clips and calls that the tests of the app share."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.__main__ import main
from app.runs import preparing
from app.runs.train_run import TrainRequest, run_training
from renderer.phantom import PhantomParams, write_phantom
from renderer.train.config import TrainConfig
from tests.app.apart import Call, command

ROOT = Path(__file__).resolve().parents[2]
CONFIG = TrainConfig(iterations=40, n_gaussians=600, checkpoint_every=10)


def request_of(clip_path: Path, run_path: Path, **changes: object) -> TrainRequest:
    return replace(TrainRequest(clip_path=clip_path, run_path=run_path, config=CONFIG), **changes)


@pytest.fixture
def vesselsplat(capfd: pytest.CaptureFixture[str]) -> Callable[..., Call]:
    """Runs a command in this process; streams are captured below Python, where decoders write too."""

    def call(*arguments: object) -> Call:
        capfd.readouterr()
        texts = [str(argument) for argument in arguments]
        if any(text.endswith(".mp4") for text in texts):
            # Video decoders are silenced when they load: in this process they may have loaded before.
            return command(*texts, folder=ROOT)
        code = main(texts)
        captured = capfd.readouterr()
        return Call(code, captured.out, captured.err)

    return call


@pytest.fixture(scope="session")
def clip_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small phantom clip of 10 frames in EndoNeRF layout. Read only."""
    path = tmp_path_factory.mktemp("clips") / "small"
    write_phantom(path, PhantomParams(n_frames=10, width=64, height=48, seed=1), "endonerf")
    return path


@pytest.fixture(scope="session")
def runs(clip_path: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """One finished run on the original frames and one on the enhanced."""
    folder = tmp_path_factory.mktemp("runs")
    paths = {name: folder / name for name in ("original", "enhanced")}
    list(run_training(request_of(clip_path, paths["original"])))
    list(run_training(request_of(clip_path, paths["enhanced"], input="enhanced")))
    return paths


@pytest.fixture(scope="session")
def windowed_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run of 112 frames with a moving camera in three windows. Read only."""
    folder = tmp_path_factory.mktemp("long")
    clip, config = folder / "clip", replace(CONFIG, iterations=40, n_gaussians=2500, window_frames=48)
    write_phantom(clip, PhantomParams(n_frames=112, width=64, height=48, camera="moving"))
    list(run_training(request_of(clip, folder / "run", config=config)))
    return folder / "run"


@pytest.fixture
def bin_files(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where an empty bin of the system keeps what is moved into it."""
    data = tmp_path_factory.mktemp("data")
    monkeypatch.setenv("XDG_DATA_HOME", str(data))
    # It is settled as the package is imported.
    for name in [name for name in sys.modules if name.startswith("send2trash")]:
        monkeypatch.delitem(sys.modules, name)
    return data / "Trash" / "files"


def tissue(seed: int, brightness: int = 160) -> np.ndarray:
    """(40, 60, 3) BGR uint8, reddish and smooth."""
    noise = np.random.default_rng(seed).normal(0, 20, (40, 60, 3))
    smooth = cv2.GaussianBlur(noise, (9, 9), 2) * 4
    return np.clip(np.array([60, 70, brightness]) + smooth, 0, 255).astype(np.uint8)


@pytest.fixture(autouse=True)
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """However busy the machine: what comes before training says nothing, unless a test wants it."""
    monkeypatch.setattr(preparing, "SECONDS_BETWEEN", 600.0)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    path = tmp_path / "in"
    path.mkdir()
    for index, brightness in enumerate((90, 160, 230)):
        cv2.imwrite(str(path / f"{index}.png"), tissue(index, brightness))
    return path
