"""Clips and calls that the tests of the app share."""

from __future__ import annotations

import shutil
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

Cli = Callable[..., Call]
ROOT = Path(__file__).resolve().parents[2]
CONFIG = TrainConfig(iterations=40, n_gaussians=600, checkpoint_every=10)


def request_of(clip_path: Path, run_path: Path, **changes: object) -> TrainRequest:
    return replace(TrainRequest(clip_path=clip_path, run_path=run_path, config=CONFIG), **changes)


@pytest.fixture
def vesselsplat(capfd: pytest.CaptureFixture[str]) -> Cli:
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
def clip_path(made_once: Callable[..., Path]) -> Path:
    """A small phantom clip of 10 frames in EndoNeRF layout. Read only."""
    params = PhantomParams(n_frames=10, width=64, height=48, seed=1)
    return made_once("clips", lambda folder: write_phantom(folder / "small", params, "endonerf")) / "small"


@pytest.fixture(scope="session")
def unmasked(clip_path: Path, made_once: Callable[..., Path]) -> Path:
    """The small clip without its masks. Read only."""
    omitted = shutil.ignore_patterns("masks", "gt_masks")
    made = made_once("unmasked", lambda folder: shutil.copytree(clip_path, folder / "clip", ignore=omitted))
    return made / "clip"


@pytest.fixture(scope="session")
def unposed(made_once: Callable[..., Path]) -> Path:
    """A phantom clip of 12 frames whose camera moves and whose poses say that it rests. Read only."""

    def make(folder: Path) -> None:
        params = PhantomParams(n_frames=12, width=160, height=128, seed=5, camera="moving", tissue="static")
        write_phantom(folder / "clip", params)
        bounds = np.load(folder / "clip/poses_bounds.npy")
        np.save(folder / "clip/poses_bounds.npy", np.repeat(bounds[:1], len(bounds), axis=0))

    return made_once("unposed", make) / "clip"


@pytest.fixture(scope="session")
def runs(clip_path: Path, made_once: Callable[..., Path]) -> dict[str, Path]:
    """One finished run on the original frames and one on the enhanced. Read only."""

    def make(folder: Path) -> None:
        list(run_training(request_of(clip_path, folder / "original")))
        list(run_training(request_of(clip_path, folder / "enhanced", input="enhanced")))

    folder = made_once("runs", make)
    return {name: folder / name for name in ("original", "enhanced")}


@pytest.fixture(scope="session")
def windowed_run(made_once: Callable[..., Path]) -> Path:
    """A finished run of 112 frames with a moving camera in three windows. Read only."""

    def make(folder: Path) -> None:
        config = replace(CONFIG, iterations=40, n_gaussians=2500, window_frames=48)
        write_phantom(folder / "clip", PhantomParams(n_frames=112, width=64, height=48, camera="moving"))
        list(run_training(request_of(folder / "clip", folder / "run", config=config)))

    return made_once("long", make) / "run"


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
