"""Live recordings killed at random moments: each plays, and lacks no more than the last second."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from app.live.recorder import WHATS
from assets import phantom_path
from renderer.clip import ClipError
from renderer.sources import open_clip
from tests.benchmarks.attack.failure import Failure
from tests.benchmarks.attack.writers import environment

LOST: Final = 1.0
"""Seconds that a kill may cost."""
LIVES: Final = (1.2, 5.0)
"""Seconds that a recording lasts, at least and at most."""
PATIENCE: Final = 60.0
"""Seconds for the command to begin."""


def attack_recordings(_: Path, count: int) -> tuple[int, list[Failure]]:
    """`count` times `vesselsplat live --record`, killed with all its threads."""
    return count, list(_attacked(count))


def _attacked(count: int) -> Iterator[Failure]:
    for number in range(count):
        with tempfile.TemporaryDirectory() as folder:
            what = WHATS[number % len(WHATS)]
            for error in _of_one(Path(folder) / "a.mp4", what, random.Random(number).uniform(*LIVES)):
                yield Failure(f"recording: {what}", number, error)


def _of_one(film: Path, what: str, lasting: float) -> Iterator[str]:
    words = [sys.executable, "-m", "app", "live", str(phantom_path()), "--record", str(film), "--what", what]
    with subprocess.Popen(
        words, env=environment(), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
    ) as child:
        began = _first_frame(film, child)
        time.sleep(lasting)
        recorded = time.time() - began
        os.killpg(child.pid, signal.SIGKILL)
    try:
        clip = open_clip(film)
        last = len(clip) - 1
        clip.read_image(last)
    except ClipError as error:
        yield f"killed after {recorded:.2f} s: {error}"
        return
    kept = (clip.frame_times or (0.0,))[last]
    if not recorded - LOST <= kept <= recorded:
        yield f"killed after {recorded:.2f} s, {kept:.2f} s of it are there"


def _first_frame(film: Path, child: subprocess.Popen[bytes]) -> float:
    """When it was recorded: its setting is written beside the film then."""
    beside, end = film.with_name(f"{film.name}.json"), time.monotonic() + PATIENCE
    while not beside.exists():
        if time.monotonic() > end or child.poll() is not None:
            raise SystemExit(f"no recording began: {child.args!r}")
        time.sleep(0.005)
    return beside.stat().st_mtime
