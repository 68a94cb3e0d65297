"""Threads of the window compute at a time also where numba has no OpenMP: kernels then take turns."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys

import numba
import pytest
from numba.core.dispatcher import Dispatcher

from app.commands import gui
from app.console.startup import take_turns_where_needed
from app.errors import UserError
from renderer.readers.clip_options import ClipOptions

TWO_THREADS = """
import threading
import numba
import numpy as np
from app.console.startup import take_turns_where_needed
from enhance import enhance_vessels

take_turns_where_needed()
image = np.random.default_rng(0).integers(0, 255, (128, 160, 3)).astype(np.uint8)
results = []
threads = [
    threading.Thread(target=lambda: results.extend(enhance_vessels(image).image for _ in range(20)))
    for _ in "ab"
]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
print(numba.threading_layer(), len(results), all((one == results[0]).all() for one in results))
"""


def test_two_threads_compute_without_openmp() -> None:
    done = subprocess.run(
        [sys.executable, "-c", TWO_THREADS],
        env=os.environ | {"NUMBA_THREADING_LAYER": "workqueue"},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (done.returncode, done.stdout.split()) == (0, ["workqueue", "40", "True"]), done.stderr


def test_with_openmp_nothing_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    before = Dispatcher.__call__
    monkeypatch.setattr(numba, "threading_layer", lambda: "omp")
    take_turns_where_needed()
    assert Dispatcher.__call__ is before


def test_windows_without_the_redistributable_is_told_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    class Lacking:
        def find_spec(self, name: str, *rest: object) -> None:
            if name == "app.gui.window":
                raise ImportError("DLL load failed while importing _imgui_bundle: not found")

    monkeypatch.setattr(sys, "meta_path", [Lacking(), *sys.meta_path])
    monkeypatch.delitem(sys.modules, "app.gui.window", raising=False)
    monkeypatch.setattr(sys, "platform", "win32")
    with pytest.raises(UserError, match="needs Microsoft's Visual C"):
        gui.run(argparse.Namespace(paths=[], live=None, igtl=None, right=None, **vars(ClipOptions())))
