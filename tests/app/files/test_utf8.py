"""Files whose names are not UTF-8: read, shown and written, or refused in a line."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from renderer.splat_files import write_splats
from tests.app.fake_steps import model_of

ROOT = Path(__file__).resolve().parents[3]
LATIN = os.fsdecode(b"caf\xe9")

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="such names are a matter of Linux")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A picture and what is meant to be a video, with names in Latin-1."""
    picture = np.random.default_rng(0).integers(0, 255, (24, 32, 3), dtype=np.uint8)
    cv2.imwrite(str(tmp_path / "plain.png"), picture)
    for suffix in (".png", ".mp4"):
        shutil.copy(tmp_path / "plain.png", tmp_path / f"{LATIN}{suffix}")
    return tmp_path


def call(*arguments: object) -> subprocess.CompletedProcess[bytes]:
    """In a process of its own, where a decoder may crash, with a stdout that refuses what is not UTF-8."""
    environment = os.environ | {"PYTHONIOENCODING": "utf-8:strict"}
    command = [sys.executable, "-m", "app", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, cwd=ROOT, env=environment)


def test_such_a_picture_is_enhanced_and_measured(folder: Path) -> None:
    done = call("enhance", folder / f"{LATIN}.png", folder / f"out-{LATIN}.png")
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"1 enhanced" in done.stdout
    assert (folder / f"out-{LATIN}.png").is_file()
    done = call("metrics", folder / f"{LATIN}.png", "--json")
    assert json.loads(done.stdout)["images"][0]["image"]["name"] == "caf?.png"
    done = call("metrics", folder / f"{LATIN}.png")
    assert (done.returncode, b"caf" in done.stdout) == (0, True)


def test_such_a_video_is_refused_in_a_line(folder: Path) -> None:
    commands: list[tuple[object, ...]] = [
        ("enhance", folder / f"{LATIN}.mp4", folder / "out"),
        ("enhance", folder / "plain.png", folder / f"out-{LATIN}.mp4"),
        ("train", folder / f"{LATIN}.mp4", "--run", folder / "run"),
    ]
    for command in commands:
        done = call(*command)
        assert (done.returncode, done.stdout, done.stderr.count(b"\n")) == (2, b"", 1)
        assert b"expected a path in UTF-8" in done.stderr
    assert not (folder / "out").exists()


def test_such_a_calibration_that_is_none_is_refused_in_a_line(folder: Path) -> None:
    done = call(
        "train", folder / "plain.png", "--calibration", folder / f"{LATIN}.png", "--run", folder / "run"
    )
    assert (done.returncode, done.stderr.count(b"\n")) == (2, 1)
    assert b"--calibration: expected a calibration" in done.stderr
    assert not (folder / "run").exists()


@pytest.mark.parametrize("form", ["html", "npz"])
def test_such_a_splat_file_is_exported(tmp_path: Path, form: str) -> None:
    write_splats(tmp_path / f"{LATIN}.ply", model_of(30).raw)
    done = call("export", tmp_path / f"{LATIN}.ply", f"--{form}", tmp_path / f"out.{form}")
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"caf?" in (tmp_path / f"out.{form}").read_bytes()


def test_such_a_run_is_trained_and_measured(clip_path: Path, tmp_path: Path) -> None:
    run = tmp_path / LATIN
    done = call("train", clip_path, "--run", run, "--iterations", 3, "--json")
    assert json.loads(done.stdout)["run"] == "caf?"
    assert json.loads(call("evaluate", run, "--json").stdout)["run"] == "caf?"
