"""Commands killed at random moments: files are old or new as a whole, and the next start clears up."""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tests.benchmarks.attack.failure import Failure
from tests.benchmarks.attack.writers import (
    WRITERS,
    Prints,
    Writer,
    command,
    environment,
    hidden,
    prints,
    run,
)

EARLIEST = 0.3
"""Seconds: Python itself starts before."""
CODES = {"SIGINT": 130, "SIGTERM": 143, "SIGHUP": 129}
SHELL = 128
"""A shell adds the signal's number to this where the signal itself ended the process."""


@dataclass(frozen=True)
class Known:
    """Of a writer: what its files are, and how long it takes."""

    writer: Writer
    before: Path
    """What is there when it is run anew."""
    old: Prints
    new: Prints
    seconds: float


def attack_kills(seeds: Path, count: int) -> tuple[int, list[Failure]]:
    """`count` processes, group and all, are killed; then the same command is run to its end."""
    return count, list(_attacked(seeds, count, {"SIGKILL": -9}))


def attack_signals(seeds: Path, count: int) -> tuple[int, list[Failure]]:
    """The same with signals that ask: one line, the code that belongs to it, and nothing is left at once."""
    return count, list(_attacked(seeds, count, CODES))


def _attacked(seeds: Path, count: int, codes: dict[str, int]) -> Iterator[Failure]:
    with tempfile.TemporaryDirectory() as scratch:
        known: dict[str, Known] = {}
        for number in range(count):
            writer = WRITERS[number % len(WRITERS)]
            if writer.name not in known:
                known[writer.name] = _learnt(seeds, Path(scratch) / "known", writer)
            name = [*codes][number // len(WRITERS) % len(codes)]
            out = Path(scratch) / str(number)
            for error in _of_one(seeds, out, known[writer.name], name, codes[name], number):
                yield Failure(f"{name}: {writer.name}", number, error)
            shutil.rmtree(out, ignore_errors=True)


def _learnt(seeds: Path, scratch: Path, writer: Writer) -> Known:
    """By running it twice, undisturbed."""
    found = []
    for which in ("old", "new"):
        out = scratch / writer.name / which
        out.mkdir(parents=True)
        began = time.monotonic()
        done = run(command(seeds, out, writer, which), out)
        if done.returncode:
            raise SystemExit(f"{writer.name}: {done.stderr}")
        found.append((prints(out), time.monotonic() - began))
    (old, _), (new, seconds) = found
    return Known(writer, scratch / writer.name / "old", {} if writer.fresh else old, new, seconds)


def _of_one(seeds: Path, out: Path, known: Known, name: str, code: int, number: int) -> Iterator[str]:
    writer = known.writer
    if writer.fresh:
        out.mkdir()
    else:
        shutil.copytree(known.before, out)
    words, moment = command(seeds, out, writer, "new"), _moment(known, number)
    ended, said = _cut_off(words, out, name, moment)
    if "Traceback" in said:
        yield f"a traceback after {moment:.2f} s: {said[-300:]}"
    if ended not in (0, code, SHELL - code):
        yield f"ended with {ended} after {moment:.2f} s: {said[-200:]}"
    yield from _wrong_now(known, out, name, moment)
    again = [*words, *(writer.goes_on if (out / "run" / "run.json").exists() else ())]
    if writer.fresh and not writer.goes_on and prints(out):
        again = [*words[:3], "info", words[4]]  # It refuses a folder that is there.
    done = run(again, out)
    if done.returncode:
        yield f"after {moment:.2f} s; the next start ended with {done.returncode}: {done.stderr[-200:]}"
    elif differing := _differing(prints(out), known.new):
        yield f"after the next start, killed after {moment:.2f} s, other files: {differing}"
    if left := hidden(out):
        yield f"left after the next start, killed after {moment:.2f} s: {left}"


def _wrong_now(known: Known, out: Path, name: str, moment: float) -> Iterator[str]:
    """Before the next start: what a person finds. Runs are not finished, all else is whole."""
    there = prints(out)
    if not known.writer.goes_on and there not in (known.old, known.new) and not _in_commit(out):
        yield f"{name} after {moment:.2f} s: neither old nor new: {_differing(there, known.new)}"
    left = [each for each in hidden(out) if not known.writer.goes_on]
    if left and name != "SIGKILL":
        yield f"left {moment:.2f} s after the start: {left}"


def _in_commit(out: Path) -> bool:
    """Between the rename that decides and the last file in its place: the next start completes it."""
    return any(name.endswith(".commit") or ".commit/" in name for name in hidden(out))


def _moment(known: Known, number: int) -> float:
    """Two in three in the latter half, where files are written."""
    rng = random.Random(number)
    least = EARLIEST if number % 3 == 0 else max(0.6 * known.seconds, EARLIEST)
    return rng.uniform(least, 1.02 * known.seconds)


def _cut_off(words: list[str], folder: Path, name: str, moment: float) -> tuple[int, str]:
    """Exit code and what was said on stderr."""
    with subprocess.Popen(
        words, cwd=folder, env=environment(), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        errors="replace", start_new_session=True,
    ) as child:  # fmt: skip
        assert child.stderr is not None
        time.sleep(moment)
        number = getattr(signal, name)
        try:
            if name == "SIGKILL":
                os.killpg(child.pid, number)
            else:
                child.send_signal(number)
        except ProcessLookupError:
            pass
        try:
            _, said = child.communicate(timeout=10)
        except subprocess.TimeoutExpired:
            os.killpg(child.pid, signal.SIGKILL)
            return 124, "hangs for more than 10 s"
        return child.returncode, said


def _differing(there: Prints, wanted: Prints) -> list[str]:
    """Names of files that are missing, too many or other than wanted; of runs, of the model alone."""
    names = sorted(there.keys() | wanted.keys())
    if any(name.endswith("model.safetensors") for name in wanted):
        names = [name for name in names if name.endswith("model.safetensors")]
    return [name for name in names if there.get(name) != wanted.get(name)]
