"""A PyAV that is installed but cannot be loaded: said in a line, and videos go on as without it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
BROKEN = 'raise ImportError("libavcodec.so.62: cannot open shared object file\\nand more of it")\n'
SAID = (
    "PyAV is installed but cannot be loaded (libavcodec.so.62: cannot open shared object file), "
    "so OpenCV is used for videos"
)


def called(folder: Path, *arguments: object) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PYTHONPATH": f"{folder / 'broken'}{os.pathsep}{ROOT}"}
    line = [sys.executable, "-m", "app", *map(str, arguments)]
    return subprocess.run(line, cwd=folder, env=environment, capture_output=True, text=True, timeout=300)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "broken" / "av").mkdir(parents=True)
    (tmp_path / "broken" / "av" / "__init__.py").write_text(BROKEN)
    writer = cv2.VideoWriter(str(tmp_path / "scope.mp4"), cv2.VideoWriter.fourcc(*"mp4v"), 10.0, (64, 48))
    for level in range(100, 160, 10):
        writer.write(np.full((48, 64, 3), (60, 80, level), np.uint8))
    writer.release()
    return tmp_path


def test_a_video_is_read_and_written_and_one_line_says_why(folder: Path) -> None:
    done = called(folder, "enhance", "scope.mp4", "out.mp4")
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    assert done.stderr.count(SAID) == 1
    assert (folder / "out.mp4").stat().st_size > 500
    told = called(folder, "info", "scope.mp4")
    assert told.returncode == 0, told.stderr
    assert "64" in told.stdout
