"""What the window's own thread does with files while the window is open: nothing, if all goes well."""

from __future__ import annotations

import os
import sys
import threading
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

FILE_EVENTS = ("open", "os.listdir", "os.scandir", "os.rename", "os.remove", "os.mkdir")

_folders: tuple[str, ...] = ()
_heard: list[str] = []


def _hear(event: str, given: tuple[object, ...]) -> None:
    """An audit hook stays for good; it hears nothing while no folder is watched."""
    if not _folders or event not in FILE_EVENTS or threading.current_thread() is not threading.main_thread():
        return
    path = given[0]
    if isinstance(path, str | os.PathLike) and os.path.abspath(path).startswith(_folders):
        caller = [f"{frame.filename}:{frame.lineno}" for frame in traceback.extract_stack()[:-1]]
        own = [line for line in caller if f"{os.sep}app{os.sep}gui{os.sep}" in line]
        _heard.append(f"{event} {os.path.abspath(path)} by {own[-1] if own else caller[-1]}")


sys.addaudithook(_hear)


@contextmanager
def files_touched(folders: Sequence[Path]) -> Iterator[list[str]]:
    """What the main thread, which is the window's, opens, lists, moves or removes below these folders."""
    global _folders
    _heard.clear()
    _folders = tuple(f"{folder.absolute()}{os.sep}" for folder in folders)
    try:
        yield _heard
    finally:
        _folders = ()
