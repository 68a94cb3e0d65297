"""A capture device, by OpenCV: V4L2, Media Foundation or AVFoundation."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from app.errors import UserError
from app.live.address import Device, LiveInput, names_itself
from app.live.sources.source import Arrived, SourceLost, Wish
from renderer.clip import ByteImage

BACKENDS: Final = {"linux": cv2.CAP_V4L2, "win32": cv2.CAP_MSMF, "darwin": cv2.CAP_AVFOUNDATION}
SILENCE = 2000
"""Milliseconds without a frame after which a device is lost."""
TRIED = 6
"""Numbers that are tried where the system does not list its devices."""
LISTED = Path("/sys/class/video4linux")

PERMISSION: Final = "System Settings, Privacy & Security, Camera"
"""Where a person of macOS allows cameras."""

OpenDevice = Callable[[int | str], cv2.VideoCapture]


def require_device(where: str) -> None:
    """Raises UserError: there is none, as far as the system tells without opening it."""
    node = Path(f"/dev/video{where}" if where.isdecimal() else where)
    if sys.platform == "linux" and not node.exists():
        raise UserError(f"expected a capture device (--list names them), got no such device: {node}")


def ask_permission(source: LiveInput) -> None:
    """To be called in the main thread, before a thread opens the source: only there macOS asks a person.

    Nothing waits for the answer; a source that is refused until then is tried again.
    """
    devices = [one.where for one in source.addresses if one.kind == "device"]
    if devices and sys.platform == "darwin":
        where = devices[0]
        opened(int(where) if where.isdecimal() else where).release()


def opened(where: int | str) -> cv2.VideoCapture:
    """By the system's own interface."""
    return cv2.VideoCapture(where, BACKENDS.get(sys.platform, cv2.CAP_ANY))


class DeviceSource:
    """Asks for what is wished, and tells what came of it."""

    def __init__(self, where: str, name: str, wish: Wish, open_device: OpenDevice = opened) -> None:
        """Raises SourceLost: the device is not there, or another program has it."""
        self._name = name
        self._capture = open_device(int(where) if where.isdecimal() else where)
        if not self._capture.isOpened():
            self._capture.release()
            forbidden = f", or not allowed in {PERMISSION}" if sys.platform == "darwin" else ""
            raise SourceLost(f"{name} cannot be opened: not there, or used by another program{forbidden}")
        self._ask(wish)
        rate = self._capture.get(cv2.CAP_PROP_FPS)
        self.frames_per_second = rate if 0 < rate < 1000 else None

    @property
    def told(self) -> str:
        get = self._capture.get
        size = f"{get(cv2.CAP_PROP_FRAME_WIDTH):.0f} × {get(cv2.CAP_PROP_FRAME_HEIGHT):.0f}"
        rate = "" if self.frames_per_second is None else f", {self.frames_per_second:.3g} frames/s"
        code = int(get(cv2.CAP_PROP_FOURCC))
        letters = bytes(code >> shift & 0xFF for shift in (0, 8, 16, 24)) if code > 0 else b""
        shape = letters.decode("ascii", errors="ignore").strip("\0 ")
        return size + rate + (f", {shape}" if shape.isprintable() and shape else "")

    def read(self) -> Arrived | None:
        if not self._capture.grab():
            raise SourceLost(f"{self._name} gives no more frames")
        at = time.perf_counter()
        # The next grab overwrites what the driver holds: it is taken out now, and only its colours later.
        done, image = self._capture.retrieve()
        if not done:
            raise SourceLost(f"{self._name} gives frames that cannot be read")
        return Arrived(lambda: _rgb(np.asarray(image, np.uint8)), at, at)

    def close(self) -> None:
        self._capture.release()

    def _ask(self, wish: Wish) -> None:
        """Format first: the sizes and rates that a device offers depend on it."""
        ask = self._capture.set
        if wish.pixel_format is not None:
            ask(cv2.CAP_PROP_FOURCC, cv2.VideoWriter.fourcc(*wish.pixel_format.upper().ljust(4)[:4]))
        if wish.size is not None:
            ask(cv2.CAP_PROP_FRAME_WIDTH, wish.size[0])
            ask(cv2.CAP_PROP_FRAME_HEIGHT, wish.size[1])
        if wish.frames_per_second is not None:
            ask(cv2.CAP_PROP_FPS, wish.frames_per_second)
        ask(cv2.CAP_PROP_BUFFERSIZE, 1)
        ask(cv2.CAP_PROP_READ_TIMEOUT_MSEC, SILENCE)


def _rgb(image: ByteImage) -> ByteImage:
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_GRAY2RGB if image.ndim == 2 else cv2.COLOR_BGR2RGB))


def devices(listed: Path = LISTED, open_device: OpenDevice = opened) -> tuple[Device, ...]:
    """Those of this machine: by name where the system tells it, else the numbers that open."""
    if sys.platform == "linux":
        return _listed_on_linux(listed)
    found = []
    for number in range(TRIED):
        capture = open_device(number)
        if capture.isOpened():
            found.append(Device(str(number), f"device {number}"))
        capture.release()
    return tuple(found)


def devices_for(*said: str | None) -> tuple[Device, ...]:
    """Those that the names may mean. Only Linux lists them without opening each: elsewhere none is looked for
    where every name says by itself what it means."""
    if sys.platform != "linux" and all(names_itself(one) for one in said if one is not None):
        return ()
    return devices()


def _listed_on_linux(listed: Path) -> tuple[Device, ...]:
    """Nodes that capture: a camera has others, for what it says of its pictures, with an index above 0."""
    if not listed.is_dir():
        return ()
    found = []
    for node in sorted(listed.iterdir(), key=lambda path: (len(path.name), path.name)):
        try:
            if (node / "index").read_text().strip() not in ("", "0"):
                continue
            name = (node / "name").read_text().strip()
        except OSError:
            continue
        number = node.name.removeprefix("video")
        found.append(Device(number if number.isdecimal() else f"/dev/{node.name}", name or node.name))
    return tuple(found)
