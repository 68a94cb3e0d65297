"""What killed processes of this machine have left: what was ready is put into place, the rest goes.

Temporary names tell whose they are: `.NAME-THREAD-PROCESS.MOMENT-MACHINE.partial`, of former versions without
the thread, or the moment when the process began. A folder with `.commit` in its place
holds a set of files that was whole, of which none, some or all have been put where they belong.
"""

from __future__ import annotations

import os
import platform
import re
import shutil
import sys
import uuid
from contextlib import suppress
from functools import cache
from pathlib import Path
from threading import get_native_id
from typing import Final
from zlib import crc32

import psutil

PARTIAL: Final = ".partial"
"""Ends the name of a file that is being written."""
COMMIT: Final = ".commit"
LONGEST: Final = 120
"""Bytes of a name; systems allow 255 with all that is added."""
INSTALLATION: Final = Path("/etc/machine-id")
_NAME = re.compile(
    r"\.(?P<name>.*?)(-\d+)?-(?P<mark>\d+(\.\d+)?)-(?P<machine>[0-9a-f]{8})"
    r"(?P<kind>\.partial|\.commit)(?P<suffix>\.[^.]*)?"
)


def temporary_name(name: str, suffix: str = "") -> str:
    """Of this thread; `suffix` is one by which writers choose their format."""
    whole = name.encode(errors="surrogateescape")
    if len(whole) > LONGEST:
        name = f"{whole[:LONGEST].decode(errors='ignore')}-{crc32(whole):08x}"
    return f".{name}-{get_native_id()}-{mark_of(os.getpid())}-{machine()}{PARTIAL}{suffix}"


def written_as(temporary: str) -> str | None:
    """The name that a file under this temporary one is to have, whoever writes it; None: it is none."""
    found = _NAME.fullmatch(temporary)
    if found is not None and found["kind"] == PARTIAL:
        name = found["name"] + (found["suffix"] or "")
    elif temporary.endswith(PARTIAL):
        name = temporary.removesuffix(PARTIAL)  # Of versions before 0.4.0.
    else:
        return None
    # Up to 0.4.0 a model was written beside a file that was being written itself.
    return written_as(name) or name


def commit_name(temporary: str) -> str:
    """Of a folder whose files are whole and may be put into place."""
    return temporary.removesuffix(PARTIAL) + COMMIT


def put_into_place(commit: Path) -> None:
    """Move the files of a set to where its folder lies, and remove it; goes on where it was cut off."""
    folder = commit.parent
    for item in sorted(commit.iterdir()):
        os.replace(item, folder / item.name)
    sync_folder(folder)
    commit.rmdir()


def clear(folder: Path) -> None:
    """Complete the sets and remove the partial files that processes of this machine have left in `folder`.

    Those of living processes and of other machines stay, and so does what cannot be moved. A folder that is
    itself being written holds none: of tens of thousands of files, each would look at all before it.
    """
    if _NAME.fullmatch(folder.name):
        return
    with suppress(OSError):
        # Of a folder of thousands of files the few with such names are sorted and looked at.
        names = filter(None, map(_NAME.fullmatch, os.listdir(folder)))
        for found in sorted(names, key=lambda found: found[0]):
            if found["machine"] in machines() and not lives(found["mark"]):
                with suppress(OSError):
                    _settle(folder / found[0], found["kind"])


def _settle(item: Path, kind: str) -> None:
    if kind == COMMIT:
        if item.is_dir() and not item.is_symlink():
            put_into_place(item)
    elif item.is_dir() and not item.is_symlink():
        shutil.rmtree(item)
    else:
        item.unlink()


def mark_of(process: int) -> str:
    """`PROCESS.MOMENT`, which no other process of this machine has: numbers are used again, by processes that
    began later. Raises OSError or psutil.Error: there is no such process."""
    return f"{process}.{_began(process)}"


def lives(mark: str) -> bool:
    """Whether the process with this mark runs; of a number alone, whether any process has it."""
    process, _, moment = mark.partition(".")
    try:
        return moment in ("", _began(int(process)))
    except (FileNotFoundError, ProcessLookupError, psutil.NoSuchProcess):
        return False
    except (psutil.Error, OSError, OverflowError):
        return True


def _began(process: int) -> str:
    """A number that stays the same, also when the clock is set. Raises OSError or psutil.Error: none."""
    if sys.platform == "linux":
        # The 22nd field, in ticks since the system started; the second, in brackets, may hold anything.
        return Path(f"/proc/{process}/stat").read_bytes().rpartition(b")")[2].split()[19].decode()
    told = psutil.Process(process)
    # By what psutil knows processes again: on macOS its public moment moves along when the clock is set.
    return f"{100 * (told._ident[1] or told.create_time()):.0f}"


@cache
def machine() -> str:
    """Folders may be shared: a process is one of the machine that it runs on.

    A Mac's name follows the network that it is in, so its hardware tells it. Elsewhere the name does, with
    the installation, as several machines may have one of the two.
    """
    return _short(_hardware() if sys.platform == "darwin" else platform.node() + _installation())


@cache
def machines() -> frozenset[str]:
    """What files call this machine: former versions had its name, or the installation or the hardware."""
    return frozenset({machine(), _short(platform.node()), _short(_installation() or _hardware())})


def _installation() -> str:
    """Empty where systems have no such name."""
    try:
        return INSTALLATION.read_text().strip()
    except OSError:
        return ""


def _hardware() -> str:
    address = uuid.getnode()
    is_made_up = bool(address >> 40 & 1)
    return platform.node() if is_made_up else str(address)


def _short(told: str) -> str:
    return f"{crc32(told.encode()):08x}"


def sync_folder(folder: Path) -> None:
    """What was renamed in it outlives a power cut; Windows has no such call, and needs none."""
    if os.name == "nt":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
