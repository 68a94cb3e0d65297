"""How a TIFF stores its numbers, by its first directory: decoders misread some layouts without a word."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

ORDERS = {b"II*\0": "<", b"MM\0*": ">", b"II+\0": "<", b"MM\0+": ">"}
LARGE = b"+"
"""In the head of a BigTIFF, whose counts and places have 64 bits."""
MOST_ENTRIES = 65535
FORMS = {3: "H", 4: "I", 16: "Q"}
"""Of a number by its kind: short, long, and long of 64 bits."""
BITS, PHOTOMETRIC, SAMPLES, PLANAR, EXTRA, FORMAT = 258, 262, 277, 284, 338, 339
LAB = frozenset({8, 9, 10})
"""In three codings."""
WHITE_IS_ZERO, BLACK_IS_ZERO, RGB, CMYK = 0, 1, 2, 5
SEPARATE = 2
UNSIGNED = 1
NUMBERS = {UNSIGNED: "uint", 2: "int", 3: "float"}
"""By their format."""
MULTIPLIED, STRAIGHT = 1, 2
"""Of a first channel beyond those of the colours, what it is as alpha; others are not specified."""


def tiff_numbers(path: Path, *tags: int) -> tuple[int, ...] | None:
    """What the directory of the first picture says under these tags, of several numbers the first, 0 for
    nothing; None: it is no TIFF.

    Raises OSError: it cannot be read.
    """
    with path.open("rb") as file:
        head = file.read(4)
        if head not in ORDERS:
            return None
        told = dict.fromkeys(tags, 0)
        try:
            told |= _directory(file, ORDERS[head], tags, is_large=LARGE in head)
        except (struct.error, OSError, OverflowError, ValueError):
            return (0,) * len(tags)  # The directory is damaged: its decoder says so.
    return tuple(told.values())


def _directory(file: BinaryIO, order: str, tags: tuple[int, ...], *, is_large: bool) -> dict[int, int]:
    """Raises struct.error, OSError, OverflowError or ValueError: it is damaged."""
    place, room = f"{order}Q" if is_large else f"{order}I", 8 if is_large else 4

    def taken(form: str) -> int:
        return int(struct.unpack(form, file.read(struct.calcsize(form)))[0])

    file.seek(8 if is_large else 4)
    file.seek(taken(place))
    count = min(taken(f"{order}Q" if is_large else f"{order}H"), MOST_ENTRIES)
    told = {}
    for entry in [file.read(4 + 2 * room) for _ in range(count)]:
        tag, kind = struct.unpack(f"{order}HH", entry[:4])
        if tag in tags:
            form = f"{order}{FORMS.get(kind, 'I')}"
            (several,) = struct.unpack_from(place, entry, 4)
            if several * struct.calcsize(form) <= room:
                told[tag] = int(struct.unpack_from(form, entry, 4 + room)[0])
            else:
                file.seek(struct.unpack_from(place, entry, 4 + room)[0])
                told[tag] = taken(form)
    return told


@dataclass(frozen=True)
class TiffLayout:
    """What its numbers are, 0 for what it does not say."""

    bits: int
    """Of a number."""
    photometric: int
    samples: int
    """Numbers of a pixel."""
    planar: int
    extra: int
    """Of the first channel beyond those of the colours."""
    format: int

    @property
    def is_lab(self) -> bool:
        return self.photometric in LAB

    @property
    def has_alpha(self) -> bool:
        """Beside grey, or of RGB where the file says so."""
        if self.photometric in (WHITE_IS_ZERO, BLACK_IS_ZERO):
            return self.samples > 1
        return self.photometric == RGB and self.extra in (MULTIPLIED, STRAIGHT)

    @property
    def numbers(self) -> str:
        """Their type, as numpy calls it."""
        return f"{NUMBERS.get(self.format, 'uint')}{self.bits}"

    @property
    def is_deep_cmyk(self) -> bool:
        return self.photometric == CMYK and self.bits > 8

    @property
    def misread(self) -> str:
        """What decoders give wrong values of without a word, as a person says it; empty for all else."""
        if self.bits <= 8:
            return ""
        if self.planar == SEPARATE and self.samples > 1:
            return f"separate planes of {self.bits} bits"
        if self.has_alpha and self.photometric != RGB:
            return f"grey with alpha of {self.bits} bits"
        if self.photometric == WHITE_IS_ZERO and self.format > UNSIGNED:
            return "signed numbers or floats with white as 0"
        return ""

    def meant(self, stored: NDArray[Any]) -> NDArray[Any]:
        """Of numbers as decoders give them those with black as 0, and with colours that are not multiplied by
        alpha; of 8 bits they are so already."""
        if stored.dtype.itemsize == 1:
            return stored
        if self.photometric == WHITE_IS_ZERO:
            inverse: NDArray[Any] = np.bitwise_not(stored)
            return inverse
        return _straight(stored) if self.has_alpha and self.extra == MULTIPLIED else stored


def tiff_layout(path: Path) -> TiffLayout | None:
    """None: it is no TIFF. Raises OSError: it cannot be read."""
    told = tiff_numbers(path, BITS, PHOTOMETRIC, SAMPLES, PLANAR, EXTRA, FORMAT)
    return None if told is None else TiffLayout(*told)


def _straight(stored: NDArray[Any]) -> NDArray[Any]:
    """(H, W, 4) colours that are multiplied by their alpha, divided by it; 0 where alpha is 0."""
    colors, alpha = np.split(stored.astype(np.float64), [3], axis=2)
    full = 1.0 if stored.dtype.kind == "f" else float(np.iinfo(stored.dtype).max)
    straight = np.divide(colors * full, alpha, out=np.zeros_like(colors), where=alpha > 0)
    if stored.dtype.kind != "f":
        straight = np.rint(np.minimum(straight, full))
    return np.concatenate([straight.astype(stored.dtype), stored[..., 3:]], axis=2)
