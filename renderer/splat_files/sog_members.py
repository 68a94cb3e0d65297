"""Where the files of a SOG lie: beside its list in a folder, or in one zip archive (`.sog`)."""

from __future__ import annotations

import io
import zipfile
import zlib
from collections.abc import Callable
from functools import partial
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Final

from renderer.regular_files import read_regular
from renderer.sog_list import LIST
from renderer.splat_files.splat_file import SplatFileError

Read = Callable[[str, int], bytes]
"""The content of a file by its name, of at most that many bytes. Raises SplatFileError, OSError."""
DAMAGED: Final = (
    zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, ValueError, OSError,
)  # fmt: skip
"""What zipfile raises for an archive that is damaged, encrypted or packed in another way."""


def beside(path: Path) -> Read:
    """What reads the files beside the list at `path`, which may have a name of its own."""

    def read(name: str, most: int) -> bytes:
        file = path if name == LIST else path.parent / own_name(name)
        try:
            return read_regular(file, most)
        except OSError as error:
            raise SplatFileError(f"expected {name} beside it, got none that can be read") from error

    return read


def archived(content: bytes) -> Read | None:
    """What reads the files of an archive, from the folder that its list is in; None where there is none."""
    try:
        archive = zipfile.ZipFile(io.BytesIO(content))
    except DAMAGED:
        return None
    lists = [name for name in archive.namelist() if PurePosixPath(name).name == LIST]
    if not lists:
        return None
    folder = min(lists, key=len).removesuffix(LIST)
    return partial(_member, archive, folder)


def _member(archive: zipfile.ZipFile, folder: str, name: str, most: int) -> bytes:
    inside = folder + own_name(name)
    try:
        with archive.open(inside) as file:
            content = file.read(most + 1)
    except KeyError as error:
        raise SplatFileError(f"expected {name} in the archive, got none") from error
    except DAMAGED as error:
        raise SplatFileError(f"expected {name} in the archive, got a damaged one") from error
    if len(content) > most:
        raise SplatFileError(f"expected {name} of at most {most} bytes, got more")
    return content


def own_name(name: str) -> str:
    """The name itself. Raises SplatFileError: it leads elsewhere than into the folder of the list."""
    if (
        name in ("", ".", "..")
        or "\0" in name
        or {name} != {PurePosixPath(name).name, PureWindowsPath(name).name}
    ):
        raise SplatFileError(f"expected the name of a file beside the list, got {name!r}")
    return name
