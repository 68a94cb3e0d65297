"""Shows a file in the system's file manager."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from shutil import which
from typing import Final

from app.errors import UserError

PATIENCE: Final = 5.0
"""Seconds in which a file manager that cannot start says so."""


@dataclass(frozen=True, eq=False)
class RevealRequest:
    """A file or folder that a person wants to see in its folder."""

    path: Path


def reveal(request: RevealRequest) -> Iterator[Path]:
    """Answers when the file manager has started. Raises UserError: it is gone, or nothing shows it."""
    path = request.path
    if not path.exists():
        raise UserError(f"{path.name} is no longer in {path.parent}")
    command = shown_by(path, sys.platform)
    program = which(command[0])
    none = f"no file manager was found to show the folder: {path.parent}"
    if program is None:
        raise UserError(none)
    try:
        process = subprocess.Popen(
            # Explorer reads its line by itself, and takes a switch within quotation marks for a name.
            " ".join(command) if sys.platform == "win32" else command,
            executable=program,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
            env=plain_environment(os.environ),
        )
    except OSError as error:
        raise UserError(f"{none} ({error.strerror})") from error
    try:
        code = process.wait(PATIENCE)
    except subprocess.TimeoutExpired:
        yield path
        process.wait()
        return
    # Windows' Explorer ends with 1 although it has opened a window.
    if code != 0 and sys.platform != "win32":
        raise UserError(none)
    yield path


def shown_by(path: Path, platform: str) -> tuple[str, ...]:
    """The command that shows a file in its folder; on Linux, where no program marks it, the folder."""
    if platform == "darwin":
        return "open", "-R", str(path)
    if platform == "win32":
        return "explorer", f'/select,"{path}"'
    return "xdg-open", str(path if path.is_dir() else path.parent)


def plain_environment(environment: Mapping[str, str]) -> dict[str, str]:
    """Without the libraries of the bundle, which are not those of the system's programs."""
    kept = {name: value for name, value in environment.items() if name != "LD_LIBRARY_PATH"}
    before = environment.get(
        "LD_LIBRARY_PATH_ORIG", None if getattr(sys, "frozen", False) else environment.get("LD_LIBRARY_PATH")
    )
    return kept | ({} if before is None else {"LD_LIBRARY_PATH": before})
