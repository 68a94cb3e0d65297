"""ONNX files of one convolution, written without the package: the fields of its protocol buffers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

FLOAT, BYTE = 1, 2


def _number(value: int) -> bytes:
    out = b""
    while value > 127:
        out, value = out + bytes([value & 127 | 128]), value >> 7
    return out + bytes([value])


def _field(number: int, value: int | bytes | str) -> bytes:
    if isinstance(value, int):
        return _number(number << 3) + _number(value)
    content = value.encode() if isinstance(value, str) else value
    return _number(number << 3 | 2) + _number(len(content)) + content


def _tensor(name: str, values: NDArray[np.float32]) -> bytes:
    dims = b"".join(_field(1, side) for side in values.shape)
    return dims + _field(2, FLOAT) + _field(8, name) + _field(9, values.astype("<f4").tobytes())


def _described(name: str, shape: Sequence[int | str], kind: int = FLOAT) -> bytes:
    dims = b"".join(_field(1, _field(1 if isinstance(side, int) else 2, side)) for side in shape)
    return _field(1, name) + _field(2, _field(1, _field(1, kind) + _field(2, dims)))


def write_convolution(
    path: Path,
    weights: NDArray[np.float32],
    bias: NDArray[np.float32],
    size: tuple[int | str, int | str] = ("h", "w"),
    channels: int = 3,
) -> Path:
    """A convolution of 1x1 with weights (classes, channels) and bias (classes,), for images of `size`, height
    and width; names stand for any."""
    node = _field(1, "image") + _field(1, "weights") + _field(1, "bias")
    node += _field(2, "scores") + _field(4, "Conv")
    graph = _field(1, node) + _field(2, "tools")
    graph += _field(5, _tensor("weights", weights[:, :, None, None])) + _field(5, _tensor("bias", bias))
    graph += _field(11, _described("image", (1, channels, *size)))
    graph += _field(12, _described("scores", (1, len(bias), *size)))
    path.write_bytes(_field(1, 8) + _field(8, _field(1, "") + _field(2, 13)) + _field(7, graph))
    return path
