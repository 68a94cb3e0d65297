"""Readers of splat files for the tests of what writes them: splat by splat, in Python's own numbers, by the
words of the published formats alone, and with nothing of the program that is tested.

PLY: github.com/graphdeco-inria/gaussian-splatting. SPZ: github.com/nianticlabs/spz, README.md, splat-types.h.
SOG: developer.playcanvas.com/user-manual/gaussian-splatting/formats/sog.
"""

from __future__ import annotations

import gzip
import io
import json
import math
import struct
import zipfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import zstandard
from PIL import Image

Vector = tuple[float, float, float]
Rows = list[tuple[float, ...]]
CONSTANT = 0.28209479177387814
RIGHT_DOWN_FORWARD, RIGHT_UP_BACK = (1, 1, 1), (1, -1, -1)


@dataclass(frozen=True)
class PlainSplat:
    """As a file has it, in its own axes."""

    position: Vector
    quat: tuple[float, float, float, float]
    """wxyz, of any length."""
    sizes: Vector
    opacity: float
    coefficients: Rows
    """1, 4, 9 or 16 of red, green and blue."""
    signs: tuple[int, int, int]
    """Of the file's axes in right, down, forward."""

    @property
    def place(self) -> Vector:
        """In right, down, forward."""
        x, y, z = (sign * value for sign, value in zip(self.signs, self.position, strict=True))
        return x, y, z

    @property
    def covariance(self) -> Rows:
        """In right, down, forward."""
        turn = _matrix(self.quat)
        axes = [[self.signs[i] * turn[i][j] * self.sizes[j] for j in range(3)] for i in range(3)]
        return [tuple(sum(a * b for a, b in zip(one, other, strict=True)) for other in axes) for one in axes]

    def color(self, direction: Vector) -> Vector:
        """Seen along a unit vector in right, down, forward."""
        x, y, z = (sign * value for sign, value in zip(self.signs, direction, strict=True))
        values = functions(x, y, z)[: len(self.coefficients)]
        r, g, b = (
            0.5 + sum(value * row[channel] for value, row in zip(values, self.coefficients, strict=True))
            for channel in range(3)
        )
        return r, g, b


def functions(x: float, y: float, z: float) -> list[float]:
    """Real spherical harmonics of degree 0 to 3, with the signs of 3D Gaussian Splatting."""
    first, second, third = 0.4886025119029199, 1.0925484305920792, 0.5900435899266435
    return [
        CONSTANT,
        -first * y, first * z, -first * x,
        second * x * y, -second * y * z, 0.31539156525252005 * (2 * z * z - x * x - y * y),
        -second * x * z, second / 2 * (x * x - y * y),
        -third * y * (3 * x * x - y * y), 2.890611442640554 * x * y * z,
        -0.4570457994644658 * y * (4 * z * z - x * x - y * y),
        0.3731763325901154 * z * (2 * z * z - 3 * x * x - 3 * y * y),
        -0.4570457994644658 * x * (4 * z * z - x * x - y * y),
        1.445305721320277 * z * (x * x - y * y), -third * x * (x * x - 3 * y * y),
    ]  # fmt: skip


def ply_splats(content: bytes) -> list[PlainSplat]:
    """Of floats in little-endian order, the only ones that the original viewer reads."""
    head, body = content.split(b"end_header\n", 1)
    lines = head.decode().split("\n")
    assert lines[:2] == ["ply", "format binary_little_endian 1.0"]
    (count,) = (int(line.split()[2]) for line in lines if line.startswith("element "))
    names = [line.split()[2] for line in lines if line.startswith("property float ")]
    assert len(names) == sum(line.startswith("property ") for line in lines)
    assert len(body) == 4 * len(names) * count
    rows = struct.iter_unpack(f"<{len(names)}f", body)
    return [_of_fields(dict(zip(names, row, strict=True))) for row in rows]


def _of_fields(fields: dict[str, float]) -> PlainSplat:
    rest = sum(name.startswith("f_rest_") for name in fields) // 3
    w, x, y, z = (fields[f"rot_{place}"] for place in range(4))
    return PlainSplat(
        (fields["x"], fields["y"], fields["z"]),
        (w, x, y, z),
        _three(lambda axis: math.exp(fields[f"scale_{axis}"])),
        1 / (1 + math.exp(-fields["opacity"])),
        [tuple(fields[f"f_dc_{channel}"] for channel in range(3))]
        + [tuple(fields[f"f_rest_{channel * rest + at}"] for channel in range(3)) for at in range(rest)],
        RIGHT_DOWN_FORWARD,
    )


def spz_splats(content: bytes) -> list[PlainSplat]:
    """Of version 3, one stream, or 4, a stream for each kind of value."""
    if content[:2] == b"\x1f\x8b":
        whole = gzip.decompress(content)
        head, body = whole[:16], whole[16:]
    else:
        head, body = content[:16], b"".join(_streams(content))
    magic, version, count, degree, bits, _, _ = struct.unpack("<IIIBBBB", head)
    assert (magic, version in (3, 4)) == (0x5053474E, True)
    bands = (degree + 1) ** 2 - 1
    planes, start = [], 0
    for width in (9, 1, 3, 3, 4, 3 * bands):
        planes.append([body[start + at * width : start + (at + 1) * width] for at in range(count)])
        start += count * width
    assert start == len(body)
    return [_of_planes(values, bits) for values in zip(*planes, strict=True)]


def _streams(content: bytes) -> Iterator[bytes]:
    streams, table = content[15], int.from_bytes(content[16:20], "little")
    start = table + 16 * streams
    for place in range(streams):
        zipped, size = struct.unpack_from("<QQ", content, table + 16 * place)
        yield zstandard.ZstdDecompressor().decompress(content[start : start + zipped], size)
        start += zipped


def _of_planes(values: Sequence[bytes], bits: int) -> PlainSplat:
    position, alpha, color, scale, rotation, harmonics = values
    return PlainSplat(
        _three(
            lambda axis: int.from_bytes(position[3 * axis : 3 * axis + 3], "little", signed=True) / 2**bits
        ),
        _smallest_three(int.from_bytes(rotation, "little")),
        _three(lambda axis: math.exp(scale[axis] / 16 - 10)),
        alpha[0] / 255,
        [tuple((byte / 255 - 0.5) / 0.15 for byte in color)]
        + [
            tuple((byte - 128) / 128 for byte in harmonics[at : at + 3]) for at in range(0, len(harmonics), 3)
        ],
        RIGHT_UP_BACK,
    )


def _smallest_three(word: int) -> tuple[float, float, float, float]:
    """Of x, y, z, w the largest is named by the upper bits; the others follow, the last one lowest."""
    largest, parts = word >> 30, [0.0] * 4
    for place in (3, 2, 1, 0):
        if place != largest:
            size, sign = word & 511, -1 if word & 512 else 1
            parts[place] = sign * size / 511 * math.sqrt(0.5)
            word >>= 10
    parts[largest] = math.sqrt(max(1 - sum(part * part for part in parts), 0))
    x, y, z, w = parts
    return w, x, y, z


def sog_splats(content: bytes) -> list[PlainSplat]:
    """Of version 2; converters leave the axes as a PLY file has them."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    said = json.loads(files["meta.json"])
    assert said["version"] == 2

    def pixels(part: str, place: int = 0) -> list[tuple[int, ...]]:
        return _pixels(files[said[part]["files"][place]])[0]

    planes = zip(
        pixels("means"), pixels("means", 1), pixels("scales"), pixels("quats"), pixels("sh0"), strict=True
    )
    rest = _palette(said, files) if "shN" in said else [[]] * said["count"]
    return [
        _of_pixels(said, *values, more) for values, more in zip([*planes][: said["count"]], rest, strict=True)
    ]


def _of_pixels(said: Any, low: Any, high: Any, scale: Any, quat: Any, color: Any, rest: Rows) -> PlainSplat:
    def coordinate(axis: int) -> float:
        least, most = said["means"]["mins"][axis], said["means"]["maxs"][axis]
        value = least + (most - least) * (high[axis] << 8 | low[axis]) / 65535
        return math.copysign(math.exp(abs(value)) - 1, value)

    largest = quat[3] - 252
    given = [(byte / 255 - 0.5) * 2 / math.sqrt(2) for byte in quat[:3]]
    parts = [*given[:largest], math.sqrt(max(1 - sum(part * part for part in given), 0)), *given[largest:]]
    w, x, y, z = parts
    codes = said["sh0"]["codebook"]
    return PlainSplat(
        _three(coordinate),
        (w, x, y, z),
        _three(lambda axis: math.exp(said["scales"]["codebook"][scale[axis]])),
        color[3] / 255,
        [tuple(codes[byte] for byte in color[:3]), *rest],
        RIGHT_DOWN_FORWARD,
    )


def _palette(said: Any, files: dict[str, bytes]) -> list[Rows]:
    """Coefficients above degree 0 of each splat: 64 rows of the palette lie beside each other."""
    part = said["shN"]
    bands, codes = (part["bands"] + 1) ** 2 - 1, part["codebook"]
    (centroids, width), (labels, _) = (_pixels(files[name]) for name in part["files"])
    assert width == 64 * bands
    rows = []
    for label in labels[: said["count"]]:
        row = label[0] | label[1] << 8
        assert row < part["count"]
        start = row // 64 * width + row % 64 * bands
        rows.append([tuple(codes[byte] for byte in pixel[:3]) for pixel in centroids[start : start + bands]])
    return rows


def _pixels(content: bytes) -> tuple[list[tuple[int, ...]], int]:
    """Row by row, and how many there are in one."""
    assert content[12:16] == b"VP8L", "without loss"
    image = Image.open(io.BytesIO(content))
    channels, values = len(image.getbands()), image.tobytes()
    return [tuple(values[at : at + channels]) for at in range(0, len(values), channels)], image.width


def _three(value: Callable[[int], float]) -> Vector:
    return value(0), value(1), value(2)


def _matrix(quat: Sequence[float]) -> Rows:
    length = math.sqrt(sum(part * part for part in quat))
    w, x, y, z = (part / length for part in quat)
    return [
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    ]
