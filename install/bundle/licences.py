"""The licences of all that a bundle holds, in one folder."""

from __future__ import annotations

import re
import shutil
import sys
import sysconfig
from collections.abc import Iterable, Iterator
from importlib.metadata import Distribution
from pathlib import Path
from typing import Final

from install.bundle.contents import BundleError, name_of

TEXT: Final = re.compile(r"(?i)^(licen[cs]e|copying|notice|authors)[^/]*$")
CODE: Final = (".py", ".pyc", ".pyi", ".so")
TOOLS: Final = frozenset({"altgraph", "pip", "pyinstaller-hooks-contrib", "setuptools", "uv", "wheel"})
"""In the environment that builds, and not in the bundle; PyInstaller's own bootloader is."""


def collect(folder: Path, carried: Iterable[Distribution], system_packages: Iterable[str]) -> list[str]:
    """Copy them to `folder`/NAME/, but for tools; returns the names of those whose licence is not
    in a file, but in metadata.

    Raises:
        BundleError: something without any word on its licence.
    """
    said = [_of(each, folder) for each in carried if name_of(each).lower() not in TOOLS]
    _copy([_pythons()], folder / f"Python {sys.version.split()[0]}")
    for package in sorted(set(system_packages)):
        _copy([Path("/usr/share/doc") / package / "copyright"], folder / package)
    return sorted(name for name in said if name)


def _of(distribution: Distribution, folder: Path) -> str:
    """Empty, or its name when it has no such file."""
    name, metadata = name_of(distribution), distribution.metadata
    place = folder / f"{name} {distribution.version}"
    texts = list(_texts(distribution))
    if texts:
        _copy(texts, place)
        return ""
    classified = [line for line in metadata.get_all("Classifier") or () if line.startswith("License")]
    words = metadata["License-Expression"] or metadata["License"] or "\n".join(classified)
    if not words:
        raise BundleError(f"expected a licence, got no word on it: {name}")
    place.mkdir(parents=True, exist_ok=True)
    (place / "LICENSE").write_text(f"{words}\n", encoding="utf-8")
    return name


def _texts(distribution: Distribution) -> Iterator[Path]:
    for file in distribution.files or ():
        if TEXT.match(file.name) and file.suffix not in CODE:
            path = Path(str(distribution.locate_file(file)))
            if path.is_file():
                yield path


def _pythons() -> Path:
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    places = (
        Path(sysconfig.get_path("stdlib")) / "LICENSE.txt",
        Path(sys.base_prefix) / "LICENSE.txt",
        Path(f"/usr/share/doc/python{version}/copyright"),
        Path(f"/usr/share/doc/libpython{version}-stdlib/copyright"),
    )
    for place in places:
        if place.is_file():
            return place
    raise BundleError(f"expected Python's licence, found none of {', '.join(map(str, places))}")


def _copy(texts: list[Path], place: Path) -> None:
    place.mkdir(parents=True, exist_ok=True)
    for text in texts:
        target = place / text.name
        # Of two files of one name, the second is told apart by its folder.
        shutil.copyfile(text, place / f"{text.parent.name} {text.name}" if target.exists() else target)
