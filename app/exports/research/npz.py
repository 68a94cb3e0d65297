"""An `.npz` file written a row at a time, so that memory does not grow with the clip."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Generator, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.errors import UserError

SUFFIX: Final = ".npy"
PROVENANCE: Final = "provenance"
BROKEN: Final = (OSError, ValueError, TypeError, KeyError, EOFError, zipfile.BadZipFile, NotImplementedError)
"""By which damaged files show."""


@dataclass(frozen=True, eq=False)
class Archive:
    """The same bytes for the same arrays: without times of day, not compressed."""

    file: zipfile.ZipFile

    def text(self, name: str, content: str) -> None:
        """As an array of bytes: some versions of numpy fail at members that are none. What is not UTF-8 in
        a file's name becomes a question mark."""
        self.array(name, np.array(content.encode(errors="replace")))

    def array(self, name: str, values: NDArray[Any]) -> None:
        """One that is there already."""
        for _ in self.rows(name, values.shape, values.dtype, values[None] if values.ndim == 0 else values):
            pass

    def rows(
        self, name: str, shape: tuple[int, ...], dtype: np.dtype[Any], rows: Iterable[NDArray[Any]]
    ) -> Generator[int, None, None]:
        """One of `shape` whose rows follow; yields how many are written."""
        said = {"descr": np.lib.format.dtype_to_descr(dtype), "fortran_order": False, "shape": shape}
        with self.file.open(zipfile.ZipInfo(name + SUFFIX), "w", force_zip64=True) as member:
            np.lib.format.write_array_header_1_0(member, said)
            for done, row in enumerate(rows, start=1):
                member.write(np.ascontiguousarray(row, dtype).tobytes())
                yield done


def read_text(path: Path, name: str) -> str:
    """Raises UserError: it is not there, or the file is damaged."""
    try:
        with zipfile.ZipFile(path) as file:
            return bytes(_read_array(_stored(file, name + SUFFIX)).item()).decode()
    except BROKEN as error:
        raise UserError(f"expected an .npz file written by VesselSplat ({error}): {path}") from error


def read_members(path: Path) -> Iterator[NDArray[Any]]:
    """All arrays of numbers, in the order of the file. Raises UserError: it is damaged."""
    try:
        with zipfile.ZipFile(path) as file:
            arrays = (_read_array(_stored(file, name)) for name in file.namelist())
            yield from (one for one in arrays if one.dtype.kind in "iuf")
    except BROKEN as error:
        raise UserError(f"expected an .npz file written by VesselSplat ({error}): {path}") from error


def _stored(file: zipfile.ZipFile, name: str) -> bytes:
    """No larger than the file itself, which is not compressed."""
    if file.getinfo(name).compress_type != zipfile.ZIP_STORED:
        raise ValueError(f"{name} is compressed")
    return file.read(name)


def _read_array(content: bytes) -> NDArray[Any]:
    stream = io.BytesIO(content)
    np.lib.format.read_magic(stream)
    shape, _, dtype = np.lib.format.read_array_header_1_0(stream)
    return np.frombuffer(content[stream.tell() :], dtype).reshape(shape)
