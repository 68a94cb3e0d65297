"""Windows that start with damaged settings, presets, queues, sessions to recover and layouts."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from tests.benchmarks.attack.failure import Failure
from tests.benchmarks.attack.mutations import mutated
from tests.benchmarks.attack.screen import screen
from tests.benchmarks.attack.session_mutations import damaged_session

WORKERS = 2
SECONDS = 40.0
"""For a start, a few frames and an end: what takes longer hangs."""
NAMES = {
    "settings.json": "settings.json", "presets.json": "presets.json", "queue-1.json": "queue-99999999.json",
    "a.vesselsplat": "autosave-99999999.vesselsplat",
}  # fmt: skip
"""Of seeds, and what the window finds them as: left by a process that has ended."""
LAYOUT = "window.ini"
NUMBER = re.compile(rb"0x[0-9A-F]{8}|\d+")
WRONG = (b"0", b"0x00000000", b"0x00000001", b"0xFFFFFFFF", b"-1", b"99999999999", b"nan", b"")


def attack_starts(seeds: Path, count: int) -> tuple[int, list[Failure]]:
    """So many starts; half of them with a damaged layout, the others with another damaged file."""
    with tempfile.TemporaryDirectory() as scratch:
        sound = Path(scratch) / "sound"
        _config(seeds, sound)
        _config(seeds, Path(scratch) / "first")
        _start(Path(scratch) / "first")  # Which leaves a layout, and takes the others over.
        for name in (LAYOUT, f"{LAYOUT}.sha256"):
            shutil.copy(Path(scratch) / "first" / name, sound)
        with ThreadPoolExecutor(WORKERS) as pool:
            found = list(pool.map(lambda number: list(_one(sound, Path(scratch), number)), range(count)))
    return count, [failure for failures in found for failure in failures]


def _config(seeds: Path, folder: Path) -> None:
    folder.mkdir()
    for name, there in NAMES.items():
        shutil.copy(seeds / name, folder / there)


def _one(sound: Path, scratch: Path, number: int) -> Iterator[Failure]:
    rng = np.random.default_rng(number)
    folder = Path(shutil.copytree(sound, scratch / str(number)))
    names = [LAYOUT] * 4 + list(NAMES.values())
    name = names[number % len(names)]
    path = folder / name
    path.write_bytes(_damaged(path.read_bytes(), name, number, rng))
    if error := _start(folder):
        yield Failure(f"start with {name}", number, error)
    shutil.rmtree(folder)


def _damaged(content: bytes, name: str, number: int, rng: np.random.Generator) -> bytes:
    if name.endswith(".vesselsplat"):
        return damaged_session(content, number)
    if name != LAYOUT or rng.random() < 0.3:
        return mutated(content, number)
    for _ in range(int(rng.integers(1, 5))):
        found = list(NUMBER.finditer(content))
        one, other = (found[int(rng.integers(len(found)))] for _ in range(2))
        value = other[0] if rng.random() < 0.7 else WRONG[int(rng.integers(len(WRONG)))]
        content = content[: one.start()] + value + content[one.end() :]
    return content


def _start(folder: Path) -> str:
    """What went wrong, empty for nothing."""
    command = [*screen(), sys.executable, "-m", "tests.benchmarks.attack.window_start", str(folder)]
    process = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    try:
        _, said = process.communicate(timeout=SECONDS)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, 9)
        process.communicate()
        return f"hangs: {SECONDS:.0f} s have not been enough"
    words = [line.strip() for line in said.splitlines() if line.strip()]
    end = f"ended with {process.returncode}: {words[-1][:200] if words else ''}"
    return end if process.returncode else ""
