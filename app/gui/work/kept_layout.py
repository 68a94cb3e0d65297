"""The layout of the window on disk: what the runner reads there can end the process, or hang it.

So it gets only what it has left itself, at the end or with another kind of content, sealed by a digest in a
file beside it.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final

from app.errors import UserError
from app.files.atomic import write_bytes
from renderer.regular_files import read_regular

NAME: Final = "window.ini"
MOST_BYTES: Final = 1 << 20
FORMER: Final = (
    (b"[Window][Pictures]", b"[Window][Images]"),
    (b"[Window][Splats]", b"[Window][Splat file]"),
)
"""Panels by their titles in older versions, and now."""
DENSITY: Final = re.compile(rb"^DpiWindowSizeFactor=(\d+(?:\.\d+)?)", re.MULTILINE)
SIZES: Final = re.compile(rb"\b(SizeRef|Size|WindowSize)=(\d+),(\d+)")
"""Of panels and of the window, in pixels."""


def seal(layout: Path) -> None:
    """The runner has written it; without a seal the next window begins as at first."""
    with suppress(OSError, UserError):
        write_bytes(_seal_of(layout), _digest(layout))


def forget(layout: Path) -> None:
    """What is kept of every kind of content does for no window as it is now."""
    with suppress(OSError):
        layout.unlink()


@dataclass(frozen=True)
class SealRequest:
    """The runner has written the layout while the window is open: without a new seal, a window that ends
    badly would lose it."""

    layout: Path
    changes: int
    """How often so far."""


def seal_anew(request: SealRequest) -> Iterator[Path]:
    """Answers a SealRequest."""
    seal(request.layout)
    yield request.layout


def put_aside_damaged(layout: Path) -> str:
    """A sentence about a layout that no window has left so, which is moved out of the way; empty where it is
    sound, or there is none. Raises OSError: it cannot be moved.
    """
    try:
        if read_regular(_seal_of(layout), MOST_BYTES) == _digest(layout):
            _rename_panels(layout)
            return ""
    except OSError:
        if not os.path.lexists(layout):
            return ""
    aside = layout.with_name(f"{layout.name}.damaged")
    os.replace(layout, aside)
    return (
        f"the window layout cannot be read, so the standard one is used; the old file is kept as {aside.name}"
    )


def _rename_panels(layout: Path) -> None:
    """So that a panel stays where it was under its former title."""
    before = now = read_regular(layout, MOST_BYTES)
    for former, title in FORMER:
        now = now.replace(former, title)
    if now != before:
        _rewrite(layout, now)


def fit(layout: Path, density: float) -> None:
    """To a screen so dense, where that of the window before was denser or less dense: its panels keep their
    sizes in lines of text. To be called before the runner reads the layout."""
    with suppress(OSError):
        before = read_regular(layout, MOST_BYTES)
        found = DENSITY.search(before)
        factor = density / (float(found[1]) or density) if found else 1.0
        if factor != 1:
            now = SIZES.sub(partial(_scaled, factor), before)
            _rewrite(layout, DENSITY.sub(b"DpiWindowSizeFactor=%g" % density, now))


def _scaled(factor: float, size: re.Match[bytes]) -> bytes:
    name, width, height = size.groups()
    return b"%s=%d,%d" % (name, round(factor * int(width)), round(factor * int(height)))


def _rewrite(layout: Path, content: bytes) -> None:
    with suppress(OSError, UserError):
        write_bytes(layout, content)
        seal(layout)


def _seal_of(layout: Path) -> Path:
    return layout.with_name(f"{layout.name}.sha256")


def _digest(layout: Path) -> bytes:
    return hashlib.sha256(read_regular(layout, MOST_BYTES)).hexdigest().encode()
