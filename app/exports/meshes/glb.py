"""glTF 2.0 in one binary file: the surface with its way through time as morph targets.

In metres where the scene is in millimetres, y up and z towards the viewer, as glTF demands.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from app.errors import UserError
from app.exports.meshes.film import Film
from app.files.embedded import KEYWORD
from app.files.provenance import NOTICE, ascii_json
from renderer.json_files import parsed
from renderer.splats import Float32Array

MAGIC, VERSION = b"glTF", 2
JSON, BINARY = 0x4E4F534A, 0x004E4942
FLOATS, INDICES = 5126, 5125
VERTICES, ELEMENTS = 34962, 34963
METRES: Final[Mapping[str, float]] = {"mm": 1e-3}
"""By the unit of a scene; of one without a scale, its own unit stands for a metre."""
TO_GLTF: Final = np.array([1, -1, -1], np.float32)
"""From x right, y down, z forward to x right, y up, z backward."""
SHAPES: Final = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}
WIDTHS: Final = {shape: width for width, shape in SHAPES.items()}
TYPES: Final = {FLOATS: np.float32, INDICES: np.uint32}


@dataclass(eq=False)
class _Buffer:
    """What is written behind the JSON, and what the JSON says of it."""

    parts: list[bytes] = field(default_factory=list)
    views: list[dict[str, Any]] = field(default_factory=list)
    accessors: list[dict[str, Any]] = field(default_factory=list)

    def view(self, content: bytes, target: int | None = None) -> int:
        start = sum(map(len, self.parts))
        self.parts.append(content + bytes(-len(content) % 4))
        about = {"buffer": 0, "byteOffset": start, "byteLength": len(content)}
        self.views.append(about | ({"target": target} if target else {}))
        return len(self.views) - 1

    def array(self, values: NDArray[Any], target: int | None = None, *, bounded: bool = False) -> int:
        """(N,) or (N, C) float32 or uint32; `bounded`: with its least and largest values."""
        kind = FLOATS if values.dtype == np.float32 else INDICES
        flat = np.ascontiguousarray(values.reshape(len(values), -1))
        bounds = {"min": flat.min(axis=0).tolist(), "max": flat.max(axis=0).tolist()} if bounded else {}
        self.accessors.append(
            {
                "bufferView": self.view(flat.tobytes(), target),
                "componentType": kind,
                "count": len(flat),
                "type": SHAPES[flat.shape[1]],
            }
            | bounds
        )
        return len(self.accessors) - 1


def glb_bytes(film: Film, unit: str, seconds: float, name: str, facts: Mapping[str, Any]) -> bytes:
    """The file; `seconds`: that the whole clip takes, `facts`: provenance."""
    scale = np.float32(METRES.get(unit, 1.0))
    positions = film.positions * TO_GLTF * scale
    buffer = _Buffer()
    attributes = {
        "POSITION": buffer.array(positions[0], VERTICES, bounded=True),
        "NORMAL": buffer.array(_unit(film.mesh.normals * TO_GLTF), VERTICES),
    }
    material: dict[str, Any] = {"metallicFactor": 0.0, "roughnessFactor": 1.0}
    textures: dict[str, Any] = {}
    if film.picture is not None and film.pixels is not None:
        attributes["TEXCOORD_0"] = buffer.array(film.pixels, VERTICES)
        material["baseColorTexture"] = {"index": 0}
        textures = _textures(buffer, film.picture)
    else:
        attributes["COLOR_0"] = buffer.array(linear(film.mesh.colors), VERTICES)
    primitive: dict[str, Any] = {
        "attributes": attributes,
        "indices": buffer.array(film.mesh.faces.astype(np.uint32).ravel(), ELEMENTS),
        "material": 0,
    }
    mesh: dict[str, Any] = {"name": name, "primitives": [primitive]}
    animations: dict[str, Any] = {}
    if len(positions) > 1:
        ways = positions[1:] - positions[0]
        primitive["targets"] = [{"POSITION": buffer.array(way, VERTICES, bounded=True)} for way in ways]
        mesh["weights"] = [0.0] * len(ways)
        animations = _animations(buffer, film.times, seconds)
    document = {
        "asset": {
            "version": "2.0",
            "generator": "VesselSplat",
            "copyright": NOTICE,
            "extras": {KEYWORD: facts, "unit": unit, "metres_per_unit": float(METRES.get(unit, 1.0))},
        },
        "extensionsUsed": ["KHR_materials_unlit"],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": name, "mesh": 0}],
        "meshes": [mesh],
        # The light of the endoscope is in the colours already.
        "materials": [
            {
                "doubleSided": True,
                "pbrMetallicRoughness": material,
                "extensions": {"KHR_materials_unlit": {}},
            }
        ],
        **textures,
        **animations,
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": sum(map(len, buffer.parts))}],
    }
    return _packed(document, b"".join(buffer.parts))


def _packed(document: Mapping[str, Any], binary: bytes) -> bytes:
    text = ascii_json(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), JSON) + text + struct.pack("<II", len(binary), BINARY) + binary
    return struct.pack("<4sII", MAGIC, VERSION, 12 + len(chunks)) + chunks


def _textures(buffer: _Buffer, picture: NDArray[np.uint8]) -> dict[str, Any]:
    done, encoded = cv2.imencode(".png", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))
    assert done
    return {
        "images": [{"bufferView": buffer.view(encoded.tobytes()), "mimeType": "image/png"}],
        "samplers": [{"magFilter": 9729, "minFilter": 9729, "wrapS": 33071, "wrapT": 33071}],
        "textures": [{"source": 0, "sampler": 0}],
    }


def _animations(buffer: _Buffer, times: Sequence[float], seconds: float) -> dict[str, Any]:
    """One target at its moment, blended straight into the next."""
    moments = (np.array(times) * seconds).astype(np.float32)
    weights = np.eye(len(times), dtype=np.float32)[:, 1:].ravel()
    sampler = {
        "input": buffer.array(moments, bounded=True),
        "output": buffer.array(weights),
        "interpolation": "LINEAR",
    }
    channel = {"sampler": 0, "target": {"node": 0, "path": "weights"}}
    return {"animations": [{"name": "clip", "samplers": [sampler], "channels": [channel]}]}


def linear(colors: Float32Array) -> Float32Array:
    """Vertex colours of glTF are linear, where textures are sRGB."""
    low = colors / 12.92
    return np.where(colors <= 0.04045, low, ((colors + 0.055) / 1.055) ** 2.4).astype(np.float32)


def _unit(normals: Float32Array) -> Float32Array:
    """A vertex without a normal has one, too."""
    missing = ~normals.any(axis=1, keepdims=True)
    towards = np.array([0, 0, 1], np.float32)
    return np.where(missing, towards, normals).astype(np.float32)


def read_glb(content: bytes) -> tuple[dict[str, Any], list[NDArray[Any]]]:
    """Provenance and arrays of a file of ours. Raises UserError: it is none, or damaged."""
    try:
        magic, version, length = struct.unpack_from("<4sII", content)
        size, kind = struct.unpack_from("<II", content, 12)
        if (magic, version, length, kind) != (MAGIC, VERSION, len(content), JSON):
            raise ValueError("not one whole binary glTF 2.0")
        document = parsed(content[20 : 20 + size].decode())
        facts = document["asset"]["extras"][KEYWORD]
        if not isinstance(facts, dict):
            raise ValueError("no provenance in it")
        start = 20 + size + 8
        return facts, [_read_array(document, one, content, start) for one in document["accessors"]]
    except (ValueError, TypeError, KeyError, IndexError, AttributeError, struct.error) as error:
        raise UserError(f"expected a GLB file written by VesselSplat ({error})") from error


def _read_array(document: Any, accessor: Any, content: bytes, start: int) -> NDArray[Any]:
    view = document["bufferViews"][accessor["bufferView"]]
    width = WIDTHS[accessor["type"]]
    kind, count, offset = TYPES[accessor["componentType"]], accessor["count"] * width, view["byteOffset"]
    if not (isinstance(count, int) and isinstance(offset, int) and count >= 0 <= offset):
        raise ValueError("an array with a place of its own is expected")
    return np.frombuffer(content, kind, count, start + offset).reshape(-1, width)
