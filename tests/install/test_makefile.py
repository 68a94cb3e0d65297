"""What the targets would do, by make's own word."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.app.conftest import ROOT

pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="no make here")


def planned(folder: Path, *arguments: str) -> list[str]:
    """Commands for a tree that nothing has been installed for, in order."""
    line = ["make", "--dry-run", "--no-print-directory", f"VENV={folder / 'none'}", *arguments]
    # The tests themselves may be run by make, whose flags are not for this one.
    own = {name: value for name, value in os.environ.items() if name not in ("MAKEFLAGS", "MAKELEVEL")}
    done = subprocess.run(line, cwd=ROOT, env=own, capture_output=True, text=True, timeout=60, check=True)
    return done.stdout.replace("\\\n", " ").splitlines()


@pytest.mark.parametrize("target", ["demo", "app", "test", "lint", "bundle"])
def test_the_system_is_looked_at_before_anything_is_made(tmp_path: Path, target: str) -> None:
    first, *others = planned(tmp_path, target)
    assert f"install/system-packages {target}" in first
    assert not any("system-packages" in line for line in others)
    assert "-m venv" in others[0]


def test_the_first_target_is_the_demo(tmp_path: Path) -> None:
    assert "install/system-packages demo" in planned(tmp_path)[0]


def test_torch_can_be_left_out(tmp_path: Path) -> None:
    [without] = [line for line in planned(tmp_path, "demo", "TORCH=no") if "--editable" in line]
    [usual] = [line for line in planned(tmp_path, "demo") if "--editable" in line]
    assert "uv pip install" in without
    assert "--overrides install/without-torch.txt" in without
    assert "--overrides" not in usual


@pytest.mark.parametrize("target", ["demo", "app"])
def test_kernels_are_compiled_before_the_app_starts(tmp_path: Path, target: str) -> None:
    lines = [line.split("bin/vesselsplat")[-1].strip() for line in planned(tmp_path, target)]
    assert lines.index("prepare") == len(lines) - 3  # Noted, and then the app itself.


def test_kernels_are_compiled_once_before_the_tests_run_on_two_processes(tmp_path: Path) -> None:
    (line,) = [line for line in planned(tmp_path, "test") if "-m pytest" in line]
    assert line.index("prepare") < line.index("-m pytest -n 2")
