"""Splats as glTF: what the extension says of each attribute, read by trimesh and by the rules of glTF."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from app.errors import UserError
from app.exports.splats.glb import splats_glb
from app.scenes.scene import open_scene
from renderer.harmonics import seen_colors
from renderer.raw_gaussians import RawGaussians
from renderer.rotations import matrix
from tests.app.conftest import Cli
from tests.renderer.splat_files.files import gaussians

TURN = np.diag([1.0, -1.0, -1.0])
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


def attributes(content: bytes) -> dict[str, np.ndarray]:
    """Of the only primitive."""
    size = int.from_bytes(content[12:16], "little")
    document = json.loads(content[20 : 20 + size])
    (primitive,) = document["meshes"][0]["primitives"]
    assert primitive["mode"] == 0
    assert primitive["extensions"]["KHR_gaussian_splatting"]["kernel"] == "ellipse"
    assert document["extensionsUsed"] == ["KHR_gaussian_splatting"]
    found = {}
    for name, place in primitive["attributes"].items():
        accessor = document["accessors"][place]
        view = document["bufferViews"][accessor["bufferView"]]
        kind = {5126: np.float32, 5121: np.uint8}[accessor["componentType"]]
        count = accessor["count"] * WIDTHS[accessor["type"]]
        values = np.frombuffer(content, kind, count, 28 + size + view["byteOffset"])
        found[name.removeprefix("KHR_gaussian_splatting:")] = values.reshape(accessor["count"], -1)
    return found


def covariances(quats: np.ndarray, scales: np.ndarray) -> np.ndarray:
    turns = matrix((quats / np.linalg.norm(quats, axis=1, keepdims=True)).T.astype(np.float64))
    stretched = turns.transpose(2, 0, 1) * scales[:, None]
    return stretched @ stretched.transpose(0, 2, 1)


@pytest.mark.parametrize("bands", [0, 3, 15])
def test_attributes_are_activated_and_turned_as_gltf_has_them(bands: int) -> None:
    raw = gaussians(40, bands)
    splats, told = raw.splats(), attributes(splats_glb(raw, "default", "mm", "a", {}))
    assert len(told) == 6 + bands
    assert np.allclose(told["POSITION"], splats.means @ TURN / 1000, atol=1e-9)
    assert np.allclose(told["OPACITY"][:, 0], splats.opacities)
    assert np.allclose(0.5 + 0.28209479177387814 * told["SH_DEGREE_0_COEF_0"], splats.colors, atol=1e-6)
    assert np.allclose(np.linalg.norm(told["ROTATION"], axis=1), 1, atol=1e-6)
    assert (told["SCALE"] >= 0).all()
    ours = TURN @ covariances(splats.quats, splats.scales) @ TURN / 1e6
    assert np.allclose(covariances(told["ROTATION"][:, [3, 0, 1, 2]], told["SCALE"]), ours, rtol=1e-4)
    # Seen from a place that is turned as the splats are, colours by direction are the same.
    place = np.array([3.0, -40.0, 7.0])
    names = [f"SH_DEGREE_{degree}_COEF_{n}" for degree in (1, 2, 3) for n in range(2 * degree + 1)][:bands]
    theirs = np.stack([told[name] for name in names], axis=1) if bands else splats.harmonics
    seen = seen_colors(told["POSITION"] * 1000, np.ascontiguousarray(theirs), splats.colors, TURN @ place)
    assert np.allclose(seen, splats.seen_from(place).colors, atol=1e-5)


def test_programs_without_the_extension_show_points(
    runs: dict[str, Path], vesselsplat: Cli, tmp_path: Path
) -> None:
    done = vesselsplat("export", runs["original"], "--glb", tmp_path, "--frames", 4)
    assert (done.code, done.error) == (0, "")
    path, scene = tmp_path / "frame-000004.glb", open_scene(runs["original"])
    (cloud,) = trimesh.load_scene(path).geometry.values()
    assert isinstance(cloud, trimesh.PointCloud)
    splats = scene.model.at(0.4)
    assert np.allclose(cloud.vertices, splats.means @ TURN / 1000, atol=1e-8)
    # Vertex colours of glTF are linear.
    colors = splats.colors.clip(0, 1).astype(np.float64)
    linear = np.where(colors <= 0.04045, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4)
    assert np.abs(cloud.colors[:, :3] - 255 * linear).max() < 0.51
    again = vesselsplat("replay", path, "--source", runs["original"])
    assert again.out.rstrip().endswith("identical"), again.error + again.out
    assert "splats" in vesselsplat("info", path).out
    assert str(tmp_path).encode() not in path.read_bytes()


def test_no_splat_and_no_rotation() -> None:
    raw = gaussians(3)
    with pytest.raises(UserError, match="expected a Gaussian at least"):
        splats_glb(raw.rows(np.zeros(0, np.int64)), "default", "mm", "a", {})
    lost: RawGaussians = replace(raw, quats=np.zeros_like(raw.quats))
    told = attributes(splats_glb(lost, "mip", "scene units", "a", {}))
    assert told["ROTATION"].tolist() == [[0, 0, 0, 1]] * 3
    assert np.allclose(told["POSITION"], raw.means @ TURN)
