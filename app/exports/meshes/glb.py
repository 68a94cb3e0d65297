"""The surface as glTF, with its way through time as morph targets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from app.exports.gltf import ELEMENTS, METRES, TO_GLTF, VERTICES, Buffer, asset, linear, packed
from app.exports.meshes.film import Film
from renderer.splats import Float32Array


def glb_bytes(film: Film, unit: str, seconds: float, name: str, facts: Mapping[str, Any]) -> bytes:
    """The file; `seconds`: that the whole clip takes, `facts`: provenance."""
    scale = np.float32(METRES.get(unit, 1.0))
    positions = film.positions * TO_GLTF * scale
    buffer = Buffer()
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
        "asset": asset(unit, facts),
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
    }
    return packed(document, buffer)


def _textures(buffer: Buffer, picture: NDArray[np.uint8]) -> dict[str, Any]:
    done, encoded = cv2.imencode(".png", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))
    assert done
    return {
        "images": [{"bufferView": buffer.view(encoded.tobytes()), "mimeType": "image/png"}],
        "samplers": [{"magFilter": 9729, "minFilter": 9729, "wrapS": 33071, "wrapT": 33071}],
        "textures": [{"source": 0, "sampler": 0}],
    }


def _animations(buffer: Buffer, times: Sequence[float], seconds: float) -> dict[str, Any]:
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


def _unit(normals: Float32Array) -> Float32Array:
    """A vertex without a normal has one, too."""
    missing = ~normals.any(axis=1, keepdims=True)
    towards = np.array([0, 0, 1], np.float32)
    return np.where(missing, towards, normals).astype(np.float32)
