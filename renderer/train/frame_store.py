"""Frames of a training: in memory up to a bound, beyond it in a file that vanishes with the process."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from io import FileIO
from pathlib import Path
from typing import Any, Generic, Self, TypeVar, overload
from weakref import finalize

import numpy as np
from numpy.typing import NDArray

from renderer.clip import Frame
from renderer.train.frames import TrainFrame

MOST_BYTES = 256_000_000
"""In memory, of one store: about 90 frames of 640x512."""

Item = TypeVar("Item", Frame, TrainFrame)


class FrameStore(Sequence[Item]):
    """Frames in the order in which they were appended; their arrays come back equal to the last bit.

    The file has no name where the system allows that, so that nothing is left of a process that is killed.
    It lies in `folder`, the system's place for temporary files when there is none.
    """

    def __init__(self, folder: Path | None = None) -> None:
        self._folder, self._left = folder, MOST_BYTES
        self._items: list[Item | _Elsewhere[Item] | None] = []
        self._file: FileIO | None = None

    @classmethod
    def of(cls, frames: Iterable[Item], folder: Path | None = None) -> Self:
        """Of frames that are taken one after the other. Raises OSError: the disk is full."""
        store = cls(folder)
        for frame in frames:
            store.append(frame)
        return store

    def append(self, frame: Item) -> None:
        """Raises OSError: it has to go to the disk, which is full."""
        values: dict[str, Any] = {item.name: getattr(frame, item.name) for item in fields(frame)}
        arrays = {name: value for name, value in values.items() if isinstance(value, np.ndarray)}
        size = sum(value.nbytes for value in arrays.values())
        if size <= self._left:
            self._left -= size
            self._items.append(frame)
        else:
            places = {name: self._write(value) for name, value in arrays.items()}
            rest = {name: value for name, value in values.items() if name not in arrays}
            self._items.append(_Elsewhere(type(frame), rest, places))

    def __len__(self) -> int:
        return len(self._items)

    @overload
    def __getitem__(self, index: int) -> Item: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Item]: ...
    def __getitem__(self, index: int | slice) -> Item | Sequence[Item]:
        if isinstance(index, slice):
            return [self[place] for place in range(*index.indices(len(self)))]
        found = self._items[index]
        if found is None:
            raise LookupError(f"expected a frame that is still stored, got {index}")
        if not isinstance(found, _Elsewhere):
            return found
        arrays: dict[str, Any] = {name: self._read(place) for name, place in found.places.items()}
        return found.kind(**found.rest, **arrays)

    def __iter__(self) -> Iterator[Item]:
        return (self[index] for index in range(len(self)))

    def take(self, index: int) -> Item:
        """The frame, which is no longer kept here; the file goes with the last one."""
        frame = self[index]
        self._items[index] = None
        if not any(self._items):
            self.clear()
        return frame

    def clear(self) -> None:
        """Let go of all frames and of the file."""
        self._items = [None] * len(self._items)
        if self._file is not None:
            self._file.close()
            self._file = None

    def _write(self, array: NDArray[Any]) -> _Place:
        if self._file is None:
            self._file = tempfile.TemporaryFile(dir=self._folder, buffering=0)  # noqa: SIM115
            finalize(self, self._file.close)
        packed = np.packbits(array) if array.dtype == np.bool_ else np.ascontiguousarray(array)
        content, start = _bytes_of(packed), self._file.seek(0, os.SEEK_END)
        while len(content):
            content = content[self._file.write(content) :]
        return _Place(start, array.shape, array.dtype)

    def _read(self, place: _Place) -> NDArray[Any]:
        assert self._file is not None
        count = int(np.prod(place.shape))
        bits = place.dtype == np.bool_
        values: NDArray[Any]
        values = np.empty(-(-count // 8), np.uint8) if bits else np.empty(place.shape, place.dtype)
        content = _bytes_of(values)
        self._file.seek(place.start)
        while len(content):
            content = content[self._file.readinto(content) :]
        return np.unpackbits(values, count=count).view(np.bool_).reshape(place.shape) if bits else values


def _bytes_of(array: NDArray[Any]) -> memoryview:
    return array.reshape(-1).view(np.uint8).data


def nearest_folder(path: Path) -> Path:
    """`path` where it is a folder, else the nearest above it."""
    absolute = path.absolute()
    return next(place for place in (absolute, *absolute.parents) if place.is_dir())


@dataclass(frozen=True)
class _Place:
    """Of an array in the file."""

    start: int
    shape: tuple[int, ...]
    dtype: np.dtype[Any]


@dataclass(frozen=True, eq=False)
class _Elsewhere(Generic[Item]):
    """A frame without its arrays, and where these are."""

    kind: type[Item]
    rest: dict[str, Any]
    places: dict[str, _Place]
