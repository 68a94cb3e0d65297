"""The shared libraries of a bundle: where each comes from, and that none is under the GPL."""

from __future__ import annotations

import ast
import re
import subprocess
from dataclasses import dataclass
from importlib.metadata import Distribution, distributions
from pathlib import Path
from typing import Final

from install.bundle.left_out import FORBIDDEN_FILES

LIBRARY: Final = re.compile(r"\.(so|dylib|dll|pyd)(\.[\d.]+)?$")
GPL_BUILD: Final = re.compile(rb"--enable-gpl|--enable-nonfree|--enable-libx26[45]")
"""What FFmpeg's libraries say of how they were configured."""


class BundleError(Exception):
    """The bundle must not be given away as it is: what is wrong, and where."""


@dataclass(frozen=True)
class Library:
    place: str
    """In the bundle."""
    origin: str
    """Distribution of Python, or package of the system, that it was taken from; empty: not known."""


def libraries(collected: Path) -> list[Library]:
    """Of PyInstaller's table of what it has collected, COLLECT-00.toc."""
    table = ast.literal_eval(collected.read_text(encoding="utf-8"))[0]
    owners = _owners()
    return sorted(
        (
            Library(place, owners.get(Path(source).resolve()) or system_package(Path(source)))
            for place, source, kind in table
            if kind in ("BINARY", "EXTENSION") and LIBRARY.search(place)
        ),
        key=lambda library: library.place,
    )


def _owners() -> dict[Path, str]:
    """Distributions by the files that they have installed."""
    return {
        Path(str(each.locate_file(file))).resolve(): name_of(each)
        for each in distributions()
        for file in each.files or ()
        if LIBRARY.search(file.name)
    }


def name_of(distribution: Distribution) -> str:
    return str(distribution.metadata["Name"])


def system_package(file: Path) -> str:
    """Of Debian and its kin; empty elsewhere, and where none owns the file."""
    for path in {file, file.resolve(), Path("/usr") / str(file.resolve()).lstrip("/")}:
        try:
            told = subprocess.run(["dpkg-query", "--search", str(path)], capture_output=True, text=True)
        except FileNotFoundError:
            return ""
        if told.returncode == 0:
            return told.stdout.partition(":")[0]
    return ""


def check(folder: Path) -> None:
    """Raises BundleError for a library that is under the GPL by its name or by its own words."""
    for path in sorted(folder.rglob("*")):
        if not LIBRARY.search(path.name) or path.is_symlink():
            continue
        if path.name.startswith(FORBIDDEN_FILES):
            raise BundleError(f"expected a bundle without {path.name.partition('.')[0]}, found {path}")
        if path.name.startswith(("libav", "libsw")) and (said := GPL_BUILD.search(path.read_bytes())):
            raise BundleError(
                f"expected an FFmpeg under the LGPL, got one built by {said[0].decode()}: {path}"
            )
