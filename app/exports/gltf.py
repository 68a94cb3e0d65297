"""glTF 2.0 in one binary file: arrays, the JSON that describes them, and how both are packed and read.

In metres where the scene is in millimetres, y up and z towards the viewer, as glTF demands.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.errors import UserError
from app.files.embedded import KEYWORD
from app.files.provenance import NOTICE, ascii_json
from renderer.glb import SHAPES, WIDTHS, glb, length_of, opened_glb
from renderer.regular_files import read_whole
from renderer.splats import Float32Array

FLOATS, INDICES, BYTES = 5126, 5125, 5121
VERTICES, ELEMENTS = 34962, 34963
METRES: Final[Mapping[str, float]] = {"mm": 1e-3}
"""By the unit of a scene; of one without a scale, its own unit stands for a metre."""
TYPES: Final = {FLOATS: np.float32, INDICES: np.uint32, BYTES: np.uint8}


@dataclass(eq=False)
class Buffer:
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
        """(N,) or (N, C) float32, uint32, or shares as uint8; `bounded`: with least and largest values."""
        kind = next(kind for kind, dtype in TYPES.items() if values.dtype == dtype)
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
            | ({"normalized": True} if kind == BYTES else {})
        )
        return len(self.accessors) - 1


def asset(unit: str, facts: Mapping[str, Any], **more: object) -> dict[str, Any]:
    """What a file says of itself; `facts`: provenance."""
    return {
        "version": "2.0",
        "generator": "VesselSplat",
        "copyright": NOTICE,
        "extras": {KEYWORD: facts, "unit": unit, "metres_per_unit": float(METRES.get(unit, 1.0))} | more,
    }


def packed(document: Mapping[str, Any], buffer: Buffer) -> bytes:
    """The file of a document, which the arrays are added to."""
    binary = b"".join(buffer.parts)
    arrays = {
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(binary)}],
    }
    return glb(ascii_json({**document, **arrays}).encode(), binary)


def linear(colors: Float32Array) -> Float32Array:
    """Vertex colours of glTF are linear, where textures are sRGB."""
    low = colors / 12.92
    return np.where(colors <= 0.04045, low, ((colors + 0.055) / 1.055) ** 2.4).astype(np.float32)


def read_glb(path: Path) -> tuple[dict[str, Any], list[NDArray[Any]]]:
    """Provenance and arrays of a file of ours. Raises UserError: it is none, or damaged."""
    content = read_whole(path)
    try:
        document, binary = opened_glb(content)
        if length_of(content) != len(content):
            raise ValueError("bytes behind its end")
        facts = document["asset"]["extras"][KEYWORD]
        if not isinstance(facts, dict):
            raise ValueError("no provenance in it")
        return facts, [_read_array(document, one, binary) for one in document["accessors"]]
    except (ValueError, TypeError, KeyError, IndexError, AttributeError, struct.error) as error:
        raise UserError(f"expected a GLB file written by VesselSplat ({error}): {path}") from error


def _read_array(document: Any, accessor: Any, binary: bytes) -> NDArray[Any]:
    view = document["bufferViews"][accessor["bufferView"]]
    width = WIDTHS[accessor["type"]]
    kind, count, offset = TYPES[accessor["componentType"]], accessor["count"] * width, view["byteOffset"]
    if not (isinstance(count, int) and isinstance(offset, int) and count >= 0 <= offset):
        raise ValueError("an array with a place of its own is expected")
    return np.frombuffer(binary, kind, count, offset).reshape(-1, width)
