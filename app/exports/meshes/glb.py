"""The surface as glTF, with its way through time as morph targets; of a model in windows a mesh of each,
which is there while it is shown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from app.exports.gltf import ELEMENTS, METRES, VERTICES, Buffer, asset, linear, packed
from app.exports.meshes.film import Film
from app.exports.records import SurfaceMesh
from app.scenes.scene import Scene
from renderer.splat_files.y_up import AXES
from renderer.splats import Float32Array


def glb_bytes(films: Sequence[Film], scene: Scene, record: SurfaceMesh) -> bytes:
    """The file of a record."""
    scale, frames = np.float32(METRES.get(scene.unit, 1.0)), len(scene.cameras)
    buffer, document = Buffer(), _Document()
    for film in films:
        _add(document, buffer, film, film.positions * AXES * scale, record)
    for node, film in enumerate(films):
        if film.frames != range(frames):
            _show(document, buffer, node, film.frames, frames, record.seconds)
    parts = {
        "asset": asset(scene.unit, record.signed),
        "extensionsUsed": ["KHR_materials_unlit"],
        "scene": 0,
        "scenes": [{"nodes": list(range(len(films)))}],
        "nodes": document.nodes,
        "meshes": document.meshes,
        "materials": document.materials,
    }
    if document.images:
        samplers = [{"magFilter": 9729, "minFilter": 9729, "wrapS": 33071, "wrapT": 33071}]
        parts |= {"images": document.images, "samplers": samplers, "textures": document.textures}
    if document.channels:
        said = {"name": "clip", "samplers": document.samplers, "channels": document.channels}
        parts["animations"] = [said]
    return packed(parts, buffer)


@dataclass
class _Document:
    """Lists of the file's JSON, which grow by what each film adds."""

    nodes: list[dict[str, Any]] = field(default_factory=list)
    meshes: list[dict[str, Any]] = field(default_factory=list)
    materials: list[dict[str, Any]] = field(default_factory=list)
    images: list[dict[str, Any]] = field(default_factory=list)
    textures: list[dict[str, Any]] = field(default_factory=list)
    samplers: list[dict[str, Any]] = field(default_factory=list)
    channels: list[dict[str, Any]] = field(default_factory=list)

    def animate(self, node: int, path: str, sampler: dict[str, Any]) -> None:
        self.channels.append({"sampler": len(self.samplers), "target": {"node": node, "path": path}})
        self.samplers.append(sampler)


def _add(
    document: _Document, buffer: Buffer, film: Film, positions: Float32Array, record: SurfaceMesh
) -> None:
    """A node with its mesh, its material, and its way through time. `positions`: as the file has them."""
    node, name = len(document.nodes), record.title
    attributes = {
        "POSITION": buffer.array(positions[0], VERTICES, bounded=True),
        "NORMAL": buffer.array(_unit(film.mesh.normals * AXES), VERTICES),
    }
    material: dict[str, Any] = {"metallicFactor": 0.0, "roughnessFactor": 1.0}
    if film.picture is not None and film.pixels is not None:
        attributes["TEXCOORD_0"] = buffer.array(film.pixels, VERTICES)
        material["baseColorTexture"] = {"index": len(document.textures)}
        document.textures.append({"source": len(document.images), "sampler": 0})
        document.images.append({"bufferView": buffer.view(_png(film.picture)), "mimeType": "image/png"})
    else:
        attributes["COLOR_0"] = buffer.array(linear(film.mesh.colors), VERTICES)
    primitive: dict[str, Any] = {
        "attributes": attributes,
        "indices": buffer.array(film.mesh.faces.astype(np.uint32).ravel(), ELEMENTS),
        "material": node,
    }
    mesh: dict[str, Any] = {"name": name, "primitives": [primitive]}
    if len(positions) > 1:
        ways = positions[1:] - positions[0]
        primitive["targets"] = [{"POSITION": buffer.array(way, VERTICES, bounded=True)} for way in ways]
        mesh["weights"] = [0.0] * len(ways)
        document.animate(node, "weights", _one_after_another(buffer, film.times, record.seconds))
    document.nodes.append({"name": name, "mesh": node})
    document.meshes.append(mesh)
    # The light of the endoscope is in the colours already.
    unlit: dict[str, Any] = {"KHR_materials_unlit": {}}
    document.materials.append({"doubleSided": True, "pbrMetallicRoughness": material, "extensions": unlit})


def _show(document: _Document, buffer: Buffer, node: int, there: range, frames: int, seconds: float) -> None:
    """At its frames alone: at other times it has no size, by which glTF hides a node (3.6.1). Without the
    animation, the first one is seen."""
    sizes = {0: 0.0} | {there.start: 1.0} | ({there.stop: 0.0} if there.stop < frames else {})
    moments = np.array([frame / frames * seconds for frame in sizes], np.float32)
    sampler = {
        "input": buffer.array(moments, bounded=True),
        "output": buffer.array(np.repeat(np.array(list(sizes.values()), np.float32)[:, None], 3, axis=1)),
        "interpolation": "STEP",
    }
    if node:
        document.nodes[node]["scale"] = [0.0, 0.0, 0.0]
    document.animate(node, "scale", sampler)


def _png(picture: NDArray[np.uint8]) -> bytes:
    done, encoded = cv2.imencode(".png", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))
    assert done
    return encoded.tobytes()


def _one_after_another(buffer: Buffer, times: Sequence[float], seconds: float) -> dict[str, Any]:
    """One target at its moment, blended straight into the next."""
    moments = (np.array(times) * seconds).astype(np.float32)
    weights = np.eye(len(times), dtype=np.float32)[:, 1:].ravel()
    return {
        "input": buffer.array(moments, bounded=True),
        "output": buffer.array(weights),
        "interpolation": "LINEAR",
    }


def _unit(normals: Float32Array) -> Float32Array:
    """A vertex without a normal has one, too."""
    missing = ~normals.any(axis=1, keepdims=True)
    towards = np.array([0, 0, 1], np.float32)
    return np.where(missing, towards, normals).astype(np.float32)
