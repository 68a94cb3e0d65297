"""Memory that was needed and is free, and giving it back; room for what is planned, before it begins."""

from __future__ import annotations

import ctypes
import re
import shutil
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Final

import psutil

from app.errors import UserError
from renderer.clip import Clip
from renderer.listing import count
from renderer.train.config import TrainConfig
from renderer.train.demand import demand, most_gaussians
from renderer.train.events import Planned
from renderer.train.frame_store import nearest_folder

M_ARENA_MAX: Final = -8
"""Of the GNU C library's malloc.h."""
ARENAS: Final = 2
CONTAINER: Final = Path("/sys/fs/cgroup")
"""Where Linux tells the limits of the group of processes that this one belongs to."""


def peak_memory_mb() -> float:
    """Largest resident memory of this process so far, in MB of 10^6 bytes."""
    if sys.platform == "win32":
        return float(psutil.Process().memory_info().peak_wset / 1e6)
    import resource

    # A process starts there with the peak of the one that spawned it; where Linux tells, its own is taken.
    status = Path("/proc/self/status")
    own = re.search(rb"VmHWM:\s*(\d+) kB", status.read_bytes()) if status.exists() else None
    if own:
        return 1024 * int(own[1]) / 1e6
    unit = 1 if sys.platform == "darwin" else 1024
    return unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6


def free_memory() -> int:
    """Bytes that processes may still take without swapping; of a container, what its limit leaves."""
    free = int(psutil.virtual_memory().available)
    with suppress(OSError, ValueError):
        most, used = (int((CONTAINER / f"memory.{name}").read_text()) for name in ("max", "current"))
        cached = re.search(r"^inactive_file (\d+)$", (CONTAINER / "memory.stat").read_text(), re.MULTILINE)
        free = min(free, most - used + (int(cached[1]) if cached else 0))
    return free


def give_back() -> None:
    """To the system: what was freed and is kept for later, on Linux by the C library's own rules for ever."""
    if (trim := _of_linux("malloc_trim")) is not None:
        trim(ctypes.c_size_t(0))


def share_memory() -> None:
    """Let all threads take memory from two places. Before there are any.

    On Linux each thread has a place of its own to take from, in which frames of all sizes leave gaps that no
    other thread fills: a window with some twenty of them grows by the hour. Elsewhere it does nothing.
    """
    if (option := _of_linux("mallopt")) is not None:
        option(M_ARENA_MAX, ARENAS)


def _of_linux(name: str) -> Callable[..., int] | None:
    """A function of the GNU C library; None elsewhere."""
    return getattr(ctypes.CDLL(None), name, None) if sys.platform == "linux" else None


def planned_in(folder: Path, clip: Clip, config: TrainConfig) -> Planned:
    """What the training will need.

    Raises:
        UserError: there is less free memory than that, or less room on the disk that `folder` will lie on.
    """
    planned, (width, height) = demand(clip, config), clip.size
    frames, gaussians = len(clip.train_indices), most_gaussians(clip, config)
    what = f"{count(frames, 'frame')} of {width}x{height} and {count(gaussians, 'Gaussian')}"
    disk = shutil.disk_usage(nearest_folder(folder)).free
    for needed, free, where in ((planned.memory, free_memory(), "memory"), (planned.disk, disk, "disk")):
        if needed > free:
            expected = f"expected {amount(needed)} of free {where} to train on {what}"
            trimming = "trim the clip to fewer frames (in the window by In and Out, else by --frames)"
            less = trimming if frames > 1 else "make the frame smaller"
            way = f"free some, or {less}" if where == "disk" else less
            raise UserError(f"{expected}, got {amount(free)} ({way}): {folder}")
    return planned


def told(planned: Planned) -> str:
    """In words."""
    return f"needs up to {amount(planned.memory)} of memory and {amount(planned.disk)} of disk"


def amount(size: int) -> str:
    return f"{size / 1e9:.1f} GB" if size >= 1e9 else f"{size / 1e6:.0f} MB"
