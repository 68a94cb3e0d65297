"""Every command that writes, on disks that fill up: a line that names the place, nothing half-written."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.benchmarks.attack.failure import Failure
from tests.benchmarks.attack.writers import WRITERS, Prints, Writer, command, hidden, prints, run

KILOBYTE = 1024
PAGE = 4 * KILOBYTE


def attack_full_disks(seeds: Path, count: int) -> tuple[int, list[Failure]]:
    """`count` commands, each on a disk with a share of the room that it needs; 0 where none is mounted."""
    with tempfile.TemporaryDirectory() as scratch:
        if not _can_mount(Path(scratch)):
            return 0, []
        return count, list(_attacked(seeds, Path(scratch), count))


def _attacked(seeds: Path, scratch: Path, count: int) -> Iterator[Failure]:
    needed: dict[str, int] = {}
    before: dict[str, Prints] = {}
    for number in range(count):
        writer = WRITERS[number % len(WRITERS)]
        if writer.name not in needed:
            needed[writer.name], before[writer.name] = _needed(seeds, scratch / "known", writer)
        turns = -(-count // len(WRITERS))
        share = (number // len(WRITERS) + 0.5) / turns
        with disk(scratch, int(share * needed[writer.name])) as out:
            for error in _of_one(seeds, out, writer, before[writer.name]):
                yield Failure(f"full disk: {writer.name}", number, error)


def _needed(seeds: Path, scratch: Path, writer: Writer) -> tuple[int, Prints]:
    """Bytes of all that it writes, and what is there before."""
    out = scratch / writer.name
    out.mkdir(parents=True)
    old: Prints = {}
    done = run(command(seeds, out, writer, "old"), out)
    if done.returncode:
        raise SystemExit(f"{writer.name}: {done.stderr}")
    if not writer.fresh:
        old = prints(out)
    size = sum(-(-path.stat().st_size // PAGE) * PAGE for path in out.rglob("*") if path.is_file())
    return size, old


def _of_one(seeds: Path, out: Path, writer: Writer, old: Prints) -> Iterator[str]:
    # What was there before lies on another disk, so that this one has room for new files alone.
    done = run(command(seeds, out, writer, "new"), out.parent)
    if done.returncode == 0:
        return
    lines = done.stderr.rstrip("\n").splitlines()
    if done.returncode != 2 or "Traceback" in done.stderr or not lines:
        yield f"ended with {done.returncode}: {done.stderr[-300:]}"
    elif str(out) not in lines[-1]:
        yield f"does not name the place: {lines[-1][:200]}"
    elif not any(word in lines[-1] for word in ("No space", "free disk", "full")):
        yield f"does not tell why: {lines[-1][:200]}"
    if not writer.goes_on and prints(out):
        yield f"half-written: {sorted(prints(out))}"
    if left := hidden(out):
        yield f"left: {left}"


@contextmanager
def disk(scratch: Path, size: int) -> Iterator[Path]:
    """A file system of that many bytes of its own."""
    place = Path(tempfile.mkdtemp(dir=scratch, prefix="disk-"))
    subprocess.run(_mount(place, max(size, 4 * PAGE)), check=True, capture_output=True)
    try:
        yield place
    finally:
        subprocess.run(["umount", "-l", str(place)], check=True, capture_output=True)
        shutil.rmtree(place, ignore_errors=True)


def _mount(place: Path, size: int) -> list[str]:
    return ["mount", "-t", "tmpfs", "-o", f"size={size // KILOBYTE}k", "tmpfs", str(place)]


def _can_mount(scratch: Path) -> bool:
    try:
        with disk(scratch, 1 << 20):
            return True
    except (OSError, subprocess.CalledProcessError):
        return False
