"""`.glb`: glTF 2.0 with splats by KHR_gaussian_splatting of Khronos, plain or as SPZ within it.

Axes are right, up, back, lengths in metres; those that this program has written are read in the unit of their
scene again.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from renderer.budget import OverBudget, budget
from renderer.glb import SPLATS as EXTENSION
from renderer.glb import WIDTHS, GlbError, opened_glb
from renderer.harmonics import BANDS
from renderer.raw_gaussians import RawGaussians, joined, logits
from renderer.rotations import matrix, quaternion
from renderer.splat_files.splat_file import PER_COLOR, SplatFile, SplatFileError, repaired
from renderer.splat_files.spz import read_spz
from renderer.splat_files.y_up import y_up
from renderer.splats import RenderMode

SPZ: Final = (f"{EXTENSION}_compression_spz_2", f"{EXTENSION}_compression_spz")
READ: Final = frozenset({EXTENSION, *SPZ, "KHR_mesh_quantization"})
"""Extensions that a file may require."""
TYPES: Final[Mapping[int, tuple[type, float]]] = {
    5120: (np.int8, 127.0), 5121: (np.uint8, 255.0), 5122: (np.int16, 32767.0), 5123: (np.uint16, 65535.0),
    5126: (np.float32, 1.0),
}  # fmt: skip
"""Of components, with the number that means 1 in normalised ones."""
DISPLAYED: Final = "srgb_rec709_display"
LINEAR: Final = "colours are to be blended as light, and are drawn as they are displayed"
LOGARITHMS: Final = "sizes below 0 are read as logarithms, which older programs wrote into glTF"
DEEPEST: Final = 64
"""Levels of nodes within each other."""
MOST_NODES: Final = 10_000
LEAST_SCALE: Final = 1e-30
BROKEN: Final = (ValueError, TypeError, KeyError, IndexError, AttributeError, RecursionError, struct.error)
"""By which damaged files show."""
Pose = NDArray[np.float64]


def read_glb_splats(content: bytes) -> SplatFile:
    """The Gaussians of the file's scene, all as one.

    Raises:
        SplatFileError: no splats in it, a kind of them that is not read, or a damaged file.
    """
    try:
        document, binary = opened_glb(content)
        _require_read(document)
        spaces = {told.get("colorSpace", DISPLAYED) for _, told, _ in _primitives(document)}
        # Values out of their range are repaired, or left out, at the end.
        with np.errstate(all="ignore"):
            files = list(_parts(document, binary))
            parts = [_placed(file.raw, pose) for file, pose in files]
        extras = _extras(document)
        modes = {extras.get("render_mode"), *(file.mode for file, _ in files)}
        mode: RenderMode = "mip" if "mip" in modes else "default"
        metres = float(extras.get("metres_per_unit", 1.0))
    except (SplatFileError, OverBudget):
        raise
    except GlbError as error:
        raise SplatFileError(str(error)) from error
    except BROKEN as error:
        raise SplatFileError("expected a glTF splat file, got a damaged one") from error
    if not parts:
        raise SplatFileError("expected Gaussian splats in the glTF file, got one without any")
    if not 0 < metres < np.inf:
        raise SplatFileError("expected a glTF splat file, got a damaged one")
    raw = joined(parts)
    with np.errstate(all="ignore"):
        means = (raw.means / metres).astype(np.float32)
        log_scales = (raw.log_scales - np.log(metres)).astype(np.float32)
    whole = repaired(replace(raw, means=means, log_scales=log_scales), mode)
    said = (*dict.fromkeys(notice for file, _ in files for notice in file.notices), *whole.notices)
    return replace(whole, notices=said if spaces == {DISPLAYED} else (*said, LINEAR))


def _require_read(document: Any) -> None:
    """Raises SplatFileError: the file means something else without an extension that is not read."""
    others = [str(one)[:60] for one in document.get("extensionsRequired", ()) if one not in READ]
    if others:
        raise SplatFileError(
            f"expected a glTF file of plain splats or SPZ, got one that requires {', '.join(others[:3])}"
        )


def _extras(document: Any) -> Mapping[str, Any]:
    """What this program says of its own files."""
    asset = document["asset"]
    extras = asset.get("extras")
    return extras if asset.get("generator") == "VesselSplat" and isinstance(extras, dict) else {}


def _parts(document: Any, binary: bytes) -> Iterator[tuple[SplatFile, Pose]]:
    """Of each primitive of splats, itself and where its node places it."""
    for primitive, told, pose in _primitives(document):
        yield _splats(document, primitive, told, binary), pose


def _primitives(document: Any) -> Iterator[tuple[Any, Any, Pose]]:
    """Those of splats: each with its extension, and where its node places it."""
    for node, pose in _nodes(document):
        if "mesh" not in node:
            continue
        for primitive in document["meshes"][_index(node["mesh"])]["primitives"]:
            told = primitive.get("extensions", {}).get(EXTENSION)
            if told is not None:
                yield primitive, told, pose


def _nodes(document: Any) -> Iterator[tuple[Any, Pose]]:
    """Of the scene that is shown, each with its place in the world."""
    nodes, scenes = document.get("nodes", []), document.get("scenes", [])
    roots = scenes[_index(document.get("scene", 0))]["nodes"] if scenes else range(len(nodes))
    waiting: list[tuple[int, Pose, int]] = [(_index(root), np.eye(4), 0) for root in roots]
    for _ in range(MOST_NODES):
        if not waiting:
            return
        number, above, level = waiting.pop()
        node = nodes[number]
        pose = above @ _pose(node)
        yield node, pose
        if level < DEEPEST:
            waiting += [(_index(child), pose, level + 1) for child in node.get("children", ())]
    raise ValueError("too many nodes")


def _pose(node: Any) -> Pose:
    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    pose = np.eye(4)
    x, y, z, w = (float(value) for value in node.get("rotation", (0, 0, 0, 1)))
    turn = matrix(np.array([w, x, y, z]))
    pose[:3, :3] = turn * np.array(node.get("scale", (1, 1, 1)), np.float64).reshape(3)
    pose[:3, 3] = np.array(node.get("translation", (0, 0, 0)), np.float64).reshape(3)
    return pose


def _splats(document: Any, primitive: Any, told: Any, binary: bytes) -> SplatFile:
    """In right, up, back, as the file has them."""
    within = told.get("extensions", {})
    packed = next((within[name] for name in SPZ if name in within), None)
    if packed is not None:
        file = read_spz(bytes(_view(document, packed["bufferView"], binary)))
        return replace(file, raw=y_up(file.raw))
    if within:
        raise SplatFileError(f"expected plain splats or SPZ in the glTF file, got {', '.join(within)[:80]}")
    if told.get("kernel", "ellipse") != "ellipse":
        raise SplatFileError(f"expected ellipses in the glTF file, got {str(told['kernel'])[:40]}")
    attributes = primitive["attributes"]

    def values(name: str, width: int) -> NDArray[np.float32]:
        if name not in attributes:
            raise SplatFileError(f"expected splats with {name} in the glTF file, got some without")
        return _array(document, attributes[name], binary, width)

    means = values("POSITION", 3)
    degrees = [degree for degree in (1, 2, 3) if f"{EXTENSION}:SH_DEGREE_{degree}_COEF_0" in attributes]
    harmonics = [
        values(f"{EXTENSION}:SH_DEGREE_{degree}_COEF_{place}", 3)
        for degree in degrees
        for place in range(2 * degree + 1)
    ]
    if len(harmonics) not in BANDS:
        raise ValueError("a degree of harmonics is missing")
    scales, said = _linear(values(f"{EXTENSION}:SCALE", 3))
    raw = RawGaussians(
        means=means,
        quats=values(f"{EXTENSION}:ROTATION", 4)[:, [3, 0, 1, 2]],
        log_scales=np.log(np.maximum(scales, np.float32(LEAST_SCALE))),
        opacity_logits=logits(values(f"{EXTENSION}:OPACITY", 1)[:, 0].astype(np.float64).clip(0, 1)),
        colors=np.float32(0.5) + np.float32(PER_COLOR) * values(f"{EXTENSION}:SH_DEGREE_0_COEF_0", 3),
        harmonics=np.stack(harmonics, axis=1) if harmonics else np.zeros((len(means), 0, 3), np.float32),
    )
    if {len(value) for value in raw.arrays().values()} != {len(means)}:
        raise ValueError("attributes of different lengths")
    return SplatFile(raw, notices=said)


def _linear(scales: NDArray[np.float32]) -> tuple[NDArray[np.float32], tuple[str, ...]]:
    """Of sizes as a file has them, and what is to be told. Raises SplatFileError: some are negative."""
    negative = int((scales < 0).sum())
    if not negative:
        return scales, ()
    # As drafts of the extension had it; logarithms of sizes in metres are negative nearly always.
    if 2 * negative > scales.size:
        return np.exp(scales), (LOGARITHMS,)
    raise SplatFileError(
        f"expected sizes of 0 or more in the glTF file, got {negative} of {scales.size} that are negative"
    )


def _array(document: Any, number: Any, binary: bytes, width: int) -> NDArray[np.float32]:
    """(N, width) of an accessor."""
    accessor = document["accessors"][_index(number)]
    if "sparse" in accessor:
        raise SplatFileError("expected plain arrays in the glTF file, got sparse ones")
    kind, full = TYPES[accessor["componentType"]]
    columns, count = WIDTHS[accessor["type"]], _index(accessor["count"])
    if width != columns:
        raise ValueError("an attribute of another width")
    budget().require(splats=count)
    view = document["bufferViews"][_index(accessor["bufferView"])]
    item = columns * np.dtype(kind).itemsize
    stride, start = _index(view.get("byteStride", 0)) or item, _index(accessor.get("byteOffset", 0))
    content = _view(document, accessor["bufferView"], binary)
    if stride < item or (count and start + (count - 1) * stride + item > len(content)):
        raise ValueError("an array beyond its place")
    found = np.ndarray((count, columns), kind, content, start, (stride, np.dtype(kind).itemsize))
    plain = found.astype(np.float32)
    return plain / np.float32(full) if full > 1 and accessor.get("normalized") is True else plain


def _view(document: Any, number: Any, binary: bytes) -> memoryview:
    view = document["bufferViews"][_index(number)]
    buffer = _index(view["buffer"])
    if "uri" in document["buffers"][buffer]:
        raise SplatFileError("expected a glTF file with all its bytes, got one that names other files")
    # Only the first is the one within the file; others without a name stand for what an extension unpacks.
    if buffer:
        raise SplatFileError(
            "expected a glTF file with all its bytes, got an array that lies in none of them"
        )
    start, size = _index(view.get("byteOffset", 0)), _index(view["byteLength"])
    if start + size > len(binary):
        raise ValueError("a place beyond the file")
    return memoryview(binary)[start : start + size]


def _index(value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise ValueError("a whole number is expected")
    return value


def _placed(raw: RawGaussians, pose: Pose) -> RawGaussians:
    """Where its node has it, then in the axes of this program.

    Raises SplatFileError: a node that skews, or turns colours by direction.
    """
    linear, size = pose[:3, :3], float(np.cbrt(abs(np.linalg.det(pose[:3, :3]))))
    if not np.isfinite(pose).all() or size < LEAST_SCALE:
        raise ValueError("a node of no size")
    turn = linear / size
    if np.linalg.det(turn) < 0 or np.abs(turn @ turn.T - np.eye(3)).max() > 1e-3:
        raise SplatFileError("expected nodes that move, turn and scale evenly, got one that skews or mirrors")
    if raw.harmonics.shape[1] and np.abs(turn - np.eye(3)).max() > 1e-6:
        raise SplatFileError("expected splats with colours by direction in a node that does not turn them")
    return y_up(
        replace(
            raw,
            means=(raw.means @ linear.T + pose[:3, 3]).astype(np.float32),
            quats=_turned(quaternion(turn), raw.quats),
            log_scales=(raw.log_scales + np.log(size)).astype(np.float32),
        )
    )


def _turned(turn: NDArray[np.float64], quats: NDArray[np.float32]) -> NDArray[np.float32]:
    """(N, 4) first each of the `quats`, then the turn."""
    w, x, y, z = turn
    after = np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]])
    return np.asarray(quats @ after.T, np.float32)
