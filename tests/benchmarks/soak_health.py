"""What a window that is used for long must not show: growth, OpenGL errors, leaks, exceptions."""

from __future__ import annotations

import ctypes
import gc
import logging
import sys
import threading
import time
from dataclasses import dataclass, field
from typing import Any

import glfw
import numpy as np
import psutil

MEGABYTE = 1 << 20
GROWTH = 0.05
NAMES = 4096
"""OpenGL counts objects from 1; a window that has more than these at once leaks."""
OBJECTS = ("Texture", "Buffer", "Framebuffer", "Program")


@dataclass(frozen=True)
class Reading:
    """The window's process at rest."""

    minute: float
    memory: float
    """Resident, MB, after collecting what Python no longer needs."""
    live: float
    """MB that the C library has given out and not got back; 0 where it does not say."""
    processor: float
    """Share of one core since the reading before."""
    files: int
    threads: int
    children: int
    objects: tuple[int, ...]
    """Of OpenGL, in the order of OBJECTS."""

    def __str__(self) -> str:
        held = " ".join(f"{name.lower()}s {n}" for name, n in zip(OBJECTS, self.objects, strict=True))
        return (
            f"{self.minute:6.1f} min  {self.memory:6.1f} MB, {self.live:6.1f} live  "
            f"{self.processor:4.0%} of a core  files {self.files}  "
            f"threads {self.threads}  children {self.children}  {held}"
        )


@dataclass
class Health:
    """Readings, and everything that went wrong between them."""

    began: float = field(default_factory=time.monotonic)
    readings: list[Reading] = field(default_factory=list)
    gl_errors: list[str] = field(default_factory=list)
    troubles: list[str] = field(default_factory=list)
    """Exceptions of any thread, and warnings that were logged."""
    due: bool = False
    """A reading is wanted, with the next frame."""
    warm: float | None = None
    """The minute by which everything has been done, and so loaded."""
    spent: tuple[float, float] = (0.0, 0.0)
    """When processor time was last looked at, and how much it was, in seconds."""

    @property
    def minutes(self) -> float:
        return (time.monotonic() - self.began) / 60

    def watch(self) -> None:
        """Take note of what nobody catches, and of what is caught and only logged."""
        handler = logging.Handler()
        handler.emit = self._note_record  # type: ignore[method-assign]
        for name, level in (("", logging.WARNING), ("app.gui.work.background", logging.DEBUG)):
            logging.getLogger(name).addHandler(handler)
            logging.getLogger(name).setLevel(level)
        threading.excepthook = lambda given: self.troubles.append(f"thread: {given.exc_value!r}")
        sys.unraisablehook = lambda given: self.troubles.append(f"ignored: {given.exc_value!r}")

    def _note_record(self, record: logging.LogRecord) -> None:
        error = record.exc_info[1] if record.exc_info else None
        self.troubles.append(f"log: {record.getMessage()}" + (f": {error!r}" if error else ""))

    def after_frame(self) -> None:
        """Errors, and a reading when one is due. In the window's thread, where its OpenGL context is."""
        get_error = _gl("glGetError", ctypes.c_uint)
        for _ in range(8):
            if (code := get_error()) == 0:
                break
            self.gl_errors.append(f"0x{code:04x}")
        if self.due:
            self.due = False
            self._read()

    def _read(self) -> None:
        gc.collect()
        process, counts = psutil.Process(), []
        for name in OBJECTS:
            exists = _gl(f"glIs{name}", ctypes.c_ubyte, ctypes.c_uint)
            counts.append(sum(bool(exists(number)) for number in range(1, NAMES)))
        reading = Reading(
            self.minutes,
            process.memory_info().rss / MEGABYTE,
            _given_out() / MEGABYTE,
            self._share(),
            process.num_fds(),
            process.num_threads(),
            len(children()),
            tuple(counts),
        )
        self.readings.append(reading)

    def _share(self) -> float:
        """Of a core, since the reading before; the jobs' own time is not in it."""
        now, used = time.monotonic(), sum(psutil.Process().cpu_times()[:2])
        before, self.spent = self.spent, (now, used)
        return float(used - before[1]) / (now - max(before[0], self.began))

    @property
    def growth(self) -> float | None:
        """Of memory from when all was warm to the end, medians of three; None where that was too short."""
        warm = float("inf") if self.warm is None else self.warm
        memory = [reading.memory for reading in self.readings if reading.minute >= warm]
        if len(memory) < 2:
            return None
        first, last = np.median(memory[:3]), np.median(memory[-3:])
        return float(last / first - 1)

    def report(self, left: list[psutil.Process]) -> bool:
        """Print it; whether every bar was kept. `left`: processes that outlived the window."""
        growth = self.growth
        told = "not measured: shorter than the warm-up" if growth is None else f"{growth:+.1%}"
        print(f"memory from when all had been done twice to the end: {told} (bar {GROWTH:.0%})")
        found = {
            "OpenGL errors": self.gl_errors,
            "leaked processes": [f"{one.pid} {' '.join(one.cmdline()[:4])}" for one in left],
            "exceptions and warnings": self.troubles,
        }
        for name, lines in found.items():
            print(f"{name}: {len(lines)}")
            for line in dict.fromkeys(lines):
                print(f"  {line} ({lines.count(line)} times)")
        return not any(found.values()) and (growth is None or growth <= GROWTH)


class _Mallinfo(ctypes.Structure):
    """struct mallinfo2 of the GNU C library, in bytes."""

    _fields_ = tuple(
        (name, ctypes.c_size_t)
        for name in (
            "arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks", "fordblks",
            "keepcost",
        )
    )  # fmt: skip


def _given_out() -> int:
    """In all arenas, and what is mapped by itself."""
    mallinfo = getattr(ctypes.CDLL(None), "mallinfo2", None) if sys.platform == "linux" else None
    if mallinfo is None:
        return 0
    mallinfo.restype = _Mallinfo
    told = mallinfo()
    return int(told.uordblks + told.hblkhd)


def children() -> list[psutil.Process]:
    """Processes of the window; multiprocessing's own tracker of resources stays as long as it does."""
    found = psutil.Process().children(recursive=True)
    return [one for one in found if not any("resource_tracker" in word for word in _words(one))]


def _words(process: psutil.Process) -> list[str]:
    try:
        return list(process.cmdline())
    except psutil.Error:
        return []


def _gl(name: str, answer: Any, *given: Any) -> Any:
    """An OpenGL function of the current context."""
    return ctypes.CFUNCTYPE(answer, *given)(glfw.get_proc_address(name))
