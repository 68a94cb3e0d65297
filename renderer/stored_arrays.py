"""Arrays in files: what each must be before a kernel, which checks no bounds, meets it."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save_file

from renderer.regular_files import require_regular

Arrays = dict[str, NDArray[Any]]
Result = TypeVar("Result")
DTYPES: Final = {"<f2": "F16", "<f4": "F32", "<f8": "F64", "<i4": "I32", "<i8": "I64", "|b1": "BOOL"}
"""As safetensors calls them."""
OR_NONE = "?"
FIRST, SECOND = "first.", "second."
"""Moments of the array whose name follows."""
ROWS = "means"
"""Array with a row for each Gaussian."""


@dataclass(frozen=True)
class Stored:
    """What is expected of an array."""

    shape: str
    """A number or the name of a length for each axis: "N 3". The same name is the same length in all arrays
    of a file; "N?" is that length or 0."""
    dtype: type = np.float32
    least: float = -np.inf
    """Of its values."""
    below: str = ""
    """Name of the length that its values stay below."""
    optional: bool = False
    """Files of earlier versions have none."""


def read_arrays(path: Path) -> tuple[Arrays, dict[str, str]]:
    """The arrays and the metadata of a safetensors file.

    Raises:
        ValueError: it cannot be read, or is damaged.
    """

    def take(file: Any) -> tuple[Arrays, dict[str, str]]:
        arrays = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        return arrays, file.metadata() or {}

    return _opened(path, take)


class LazyArrays(Mapping[str, NDArray[Any]]):
    """Arrays by name, each read when it is asked for, again each time."""

    def __init__(self, names: Sequence[str], read: Callable[[str], NDArray[Any]]) -> None:
        self._names, self._read = dict.fromkeys(names), read

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name not in self._names:
            raise KeyError(name)
        return self._read(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


def stored_arrays(path: Path) -> LazyArrays:
    """Those of a safetensors file, opened anew for each: while it is open, all that was read of it lies in
    memory.

    Raises:
        ValueError: it cannot be read, or is damaged; so does reading one of them.
    """
    names = _opened(path, lambda file: list(file.keys()))
    return LazyArrays(names, lambda name: _opened(path, lambda file: file.get_tensor(name)))


def stored_metadata(path: Path) -> dict[str, str]:
    """Of a safetensors file. Raises ValueError: it cannot be read, or is damaged."""
    return _opened(path, lambda file: file.metadata() or {})


def _opened(path: Path, take: Callable[[Any], Result]) -> Result:
    try:
        require_regular(path)
        return take(safe_open(path, framework="numpy"))
    except (SafetensorError, OSError, TypeError, AttributeError, KeyError, ValueError) as error:
        raise ValueError(f"expected a file in safetensors format, got {error}: {path}") from error


def write_arrays(
    path: Path, arrays: Mapping[str, NDArray[Any]], metadata: dict[str, str] | None = None
) -> None:
    """A safetensors file, written from the arrays as they lie in memory: they may fill half of it. Those
    that are read when they are asked for are written one after the other.

    Raises:
        OSError: it cannot be written.
    """
    if isinstance(arrays, LazyArrays):
        _write_one_by_one(path, arrays, metadata)
        return
    dense = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    # The library's files are for their owner alone; this one has the mode that the user's files have.
    path.touch()
    mode = path.stat().st_mode
    try:
        save_file(dense, path, metadata)
        path.chmod(mode)
    except SafetensorError as error:
        number = re.search(r"os error (\d+)", str(error))
        if number is None:
            raise
        raise OSError(int(number[1]), os.strerror(int(number[1])), str(path)) from error


def _write_one_by_one(path: Path, arrays: LazyArrays, metadata: dict[str, str] | None) -> None:
    """The format of safetensors: the header's length in 8 bytes, the header as JSON, all values."""
    header: dict[str, Any] = {"__metadata__": metadata} if metadata else {}
    end = 0
    for name, array in arrays.items():
        start, end = end, end + array.nbytes
        told = {"dtype": DTYPES[array.dtype.str], "shape": array.shape, "data_offsets": (start, end)}
        header[name] = told
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    with path.open("wb") as file:
        file.write(len(text).to_bytes(8, "little") + text)
        for array in arrays.values():
            file.write(np.ascontiguousarray(array).data)


def check(arrays: Mapping[str, NDArray[Any]], layout: Mapping[str, Stored], lengths: dict[str, int]) -> None:
    """Hold arrays against their layout; `lengths` are those known before, the others are added.

    Raises:
        ValueError: an array is missing, of another shape or type, not finite, or out of its range.
    """
    for name, stored in layout.items():
        if name in arrays:
            _check_shape(name, arrays[name], stored, lengths)
        elif not stored.optional:
            raise ValueError(f"expected an array {name}, found none")
    for name, stored in layout.items():
        if name in arrays:
            _check_values(name, arrays[name], stored, lengths)


def check_state(given: Mapping[str, NDArray[Any]], own: Mapping[str, NDArray[Any]]) -> None:
    """Hold the state of a training against that of one that has just begun.

    The number of Gaussians may differ, since some are added and removed, and that of harmonics, which come
    later.

    Raises:
        ValueError: an array is missing, of another shape or type, not finite, or a second moment below 0.
    """
    for name, expected in own.items():
        if name not in given:
            raise ValueError(f"expected an array {name}, found none")
        array = given[name]
        _check_type(name, array, expected.dtype)
        of = name.removeprefix(FIRST).removeprefix(SECOND)
        if name != of and of in given:  # Each trainer lays out moments as it needs them, in copies.
            fits = array.shape == given[of].shape
        else:
            grown = (len(own[ROWS]), len(given[ROWS]))
            fits = _same_but_grown(array.shape, expected.shape, grown, free=1 if of == "harmonics" else None)
            _check_layout(name, array)
        if not fits:
            raise ValueError(f"expected {name} of shape {_told(expected.shape)}, got {_told(array.shape)}")
        if not np.isfinite(array).all() or (name.startswith(SECOND) and (array < 0).any()):
            raise ValueError(f"expected finite values, and second moments of at least 0, in {name}")


def _same_but_grown(
    shape: tuple[int, ...], expected: tuple[int, ...], grown: tuple[int, int], free: int | None
) -> bool:
    """Whether all lengths are as expected, but for those that grew alike, and the axis that is free."""
    lengths = enumerate(zip(shape, expected, strict=False))
    return len(shape) == len(expected) and all(
        axis == free or new == old or (old, new) == grown for axis, (new, old) in lengths
    )


def _check_shape(name: str, array: NDArray[Any], stored: Stored, lengths: dict[str, int]) -> None:
    _check_type(name, array, np.dtype(stored.dtype))
    _check_layout(name, array)
    axes = stored.shape.split()
    fits = array.ndim == len(axes)
    for length, axis in zip(array.shape, axes, strict=False):
        key = axis.removesuffix(OR_NONE)
        if axis.endswith(OR_NONE) and length == 0:
            continue
        fits &= length == (int(key) if key.isdigit() else lengths.setdefault(key, length))
    if not fits:
        known = " ".join(_known(axis, lengths) for axis in axes)
        raise ValueError(f"expected {name} of shape {known}, got {_told(array.shape)}")


def _check_type(name: str, array: NDArray[Any], dtype: np.dtype[Any]) -> None:
    if array.dtype != dtype:
        raise ValueError(f"expected {name} of {dtype}, got {array.dtype}")


def _check_layout(name: str, array: NDArray[Any]) -> None:
    if not array.flags.c_contiguous:
        raise ValueError(f"expected {name} in contiguous memory, row by row")


def _check_values(name: str, array: NDArray[Any], stored: Stored, lengths: dict[str, int]) -> None:
    if not np.isfinite(array).all():
        raise ValueError(
            f"expected finite values in {name}, got {np.count_nonzero(~np.isfinite(array))} others"
        )
    below = lengths[stored.below] if stored.below else np.inf
    if array.size and not (array.min() >= stored.least and array.max() < below):
        span = f"{array.min()} to {array.max()}"
        raise ValueError(f"expected {name} of at least {stored.least:g} and below {below:g}, got {span}")


def _known(axis: str, lengths: dict[str, int]) -> str:
    key = axis.removesuffix(OR_NONE)
    return str(lengths.get(key, key)) + (" or 0" if axis != key else "")


def _told(shape: tuple[int, ...]) -> str:
    return " ".join(map(str, shape)) or "a single number"
