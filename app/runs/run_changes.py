"""Run folders renamed and deleted by hand: only runs, and never one that is in training."""

from __future__ import annotations

import os
import re
import shutil
from dataclasses import dataclass
from pathlib import Path
from zlib import crc32

from app.errors import UserError
from app.files.bin import has_bin, move_to_bin
from app.files.device_names import is_device
from app.runs.run_folder import RunFolder
from app.runs.run_lock import locked
from renderer.atomic_files import patiently
from renderer.leftovers import LONGEST


@dataclass(frozen=True)
class Footprint:
    """What a folder takes, with all that lies below it."""

    files: int
    size: int
    """Bytes."""
    has_bin: bool = True
    """The system has a bin that takes it."""


def folder_name(wanted: str, ending: str = "") -> str:
    """As near to what a person typed as every system and its bin allow, and an ending that stays whole; empty
    where nothing is left of what was typed."""
    whole = re.sub(r"[^\w.-]+", "-", wanted).strip(".-").encode(errors="ignore")
    name = whole[: LONGEST - len(ending)].decode(errors="ignore").strip(".-")
    name = f"{name}{ending}" if name else ""
    return f"run-{name}" if is_device(name) else name


def footprint(path: Path) -> Footprint:
    """Links count as themselves. Raises OSError: the folder cannot be looked through."""
    if not path.is_dir():
        raise UserError(f"expected a folder, got none: {path}")
    sizes = [os.lstat(Path(folder, name)).st_size for folder, _, names in os.walk(path) for name in names]
    return Footprint(len(sizes), sum(sizes), has_bin(path))


def rename_run(path: Path, wanted: str) -> Path:
    """Where it lies now. Raises UserError or OSError: it stays as it was."""
    name = folder_name(wanted)
    if not name:
        raise UserError(f"expected a name with letters or digits for the run, got {wanted!r}")
    there = path.with_name(name)
    if there == path:
        return path
    _require_free(path)
    # Where upper and lower case are one, another spelling of its own name is no other folder.
    if there.exists() and not there.samefile(path):
        raise UserError(f"expected a name that no other run has, got {name}: {there}")
    patiently(path.rename, there)
    return there


def delete_run(path: Path, *, for_good: bool = False) -> None:
    """With all that lies in its folder: to the system's bin unless `for_good`.

    Raises UserError or OSError: it stays, but `for_good` some of it may be gone.
    """
    _require_free(path)
    if not for_good:
        move_to_bin(path)
        return
    # In one step it is no run any more: what is cut short leaves nothing that looks like one.
    name = os.fsencode(path.name)
    doomed = path.with_name(f".{path.name if len(name) <= LONGEST else f'{crc32(name):08x}'}.deleted")
    shutil.rmtree(doomed, ignore_errors=True)  # Of one that was cut short.
    patiently(path.rename, doomed)
    RunFolder(doomed).record_path.unlink()
    shutil.rmtree(doomed)


def _require_free(path: Path) -> None:
    """Raises UserError: it is no run folder, a link to one, or in training."""
    if path.is_symlink() or not RunFolder(path).is_run:
        raise UserError(f"expected a run folder with run.json, found none in {path}")
    with locked(path):
        pass
