"""The short form of the attacks; `python -m tests.benchmarks.attack` is the long one.

Without signals: tests/app/console/test_ending.py sends them.
"""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.app.conftest import ROOT


@pytest.mark.slow
@pytest.mark.display
@pytest.mark.skipif(sys.platform != "linux", reason="limits and kills processes as Linux does")
def test_nothing_breaks_under_a_short_attack() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "tests.benchmarks.attack", "--short"],
        cwd=ROOT, capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip
    assert done.returncode == 0, f"{done.stdout}\n{done.stderr[-2000:]}"
    counted = [line for line in done.stdout.splitlines() if ", 0 failures, " in line]
    assert len(counted) == 7
