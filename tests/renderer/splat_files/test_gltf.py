"""glTF with splats: of a foreign writer, with nodes, as SPZ within it, and damaged."""

from __future__ import annotations

import copy
import json
import struct
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fourdgs import GaussianSet, to_gltf

from renderer.budget import OverBudget
from renderer.raw_gaussians import RawGaussians
from renderer.rotations import matrix, unit_quats
from renderer.splat_files import SplatFile, SplatFileError, is_named_as_splats, read_splats
from renderer.splat_files.gltf import read_glb_splats
from renderer.splat_files.spz import read_spz
from renderer.splat_files.spz_writing import spz_bytes
from renderer.splats import RenderMode
from tests.benchmarks.attack.mutations import mutated
from tests.renderer.splat_files.files import gaussians

UP = np.array([1, -1, -1])
TO_OURS = np.diag(UP)
NAME = "KHR_gaussian_splatting"
CONSTANT = 0.28209479177387814
TURN = np.array([0.5, 0.5, -0.5, 0.5])
"""wxyz."""


def covariances(raw: RawGaussians) -> np.ndarray:
    turns = matrix(unit_quats(raw.quats).T.astype(np.float64)).transpose(2, 0, 1)
    sized = turns * np.exp(raw.log_scales)[:, None, :]
    return sized @ sized.transpose(0, 2, 1)


def packed(document: Mapping[str, Any], binary: bytes) -> bytes:
    """A whole file."""
    text = json.dumps(document).encode()
    return framed(text + b" " * (-len(text) % 4), binary + bytes(-len(binary) % 4))


def framed(text: bytes, binary: bytes) -> bytes:
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def plain(raw: RawGaussians, **node: object) -> tuple[dict[str, Any], bytes]:
    """By the words of the extension alone, values in right, up, back."""
    values = {
        "POSITION": raw.means,
        f"{NAME}:ROTATION": unit_quats(raw.quats)[:, [1, 2, 3, 0]],
        f"{NAME}:SCALE": np.exp(raw.log_scales),
        f"{NAME}:OPACITY": 1 / (1 + np.exp(-raw.opacity_logits)),
        f"{NAME}:SH_DEGREE_0_COEF_0": (raw.colors - 0.5) / CONSTANT,
    }
    coefficients = [(degree, place) for degree in (1, 2, 3) for place in range(2 * degree + 1)]
    for at, (degree, place) in enumerate(coefficients[: raw.harmonics.shape[1]]):
        values[f"{NAME}:SH_DEGREE_{degree}_COEF_{place}"] = raw.harmonics[:, at]
    views, accessors, binary = [], [], b""
    for value in values.values():
        content = np.ascontiguousarray(value, np.float32).tobytes()
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(content)})
        kind = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}[value.reshape(len(raw), -1).shape[1]]
        accessors.append(
            {"bufferView": len(views) - 1, "componentType": 5126, "count": len(raw), "type": kind}
        )
        binary += content
    primitive = {
        "mode": 0,
        "attributes": {name: at for at, name in enumerate(values)},
        "extensions": {NAME: {"kernel": "ellipse", "colorSpace": "srgb_rec709_display"}},
    }
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, **node}],
        "meshes": [{"primitives": [primitive]}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    }
    return document, binary


def same(file: SplatFile, raw: RawGaussians, turn: np.ndarray = TO_OURS, size: float = 1.0) -> None:
    """What is read is `raw` turned and scaled."""
    assert len(file.raw) == len(raw)
    assert np.allclose(file.raw.means, size * raw.means @ turn.T, rtol=1e-4, atol=1e-3 * size)
    ours = size**2 * turn @ covariances(raw) @ turn.T
    assert np.allclose(covariances(file.raw), ours, rtol=1e-3, atol=1e-4 * size**2)
    assert np.allclose(file.raw.splats().opacities, raw.splats().opacities, atol=1e-5)
    assert np.allclose(file.raw.colors, raw.colors, atol=1e-5)


@pytest.mark.parametrize("axes", ["y-up-right-handed", "z-up-right-handed"])
def test_a_foreign_writer_is_understood(tmp_path: Path, axes: str) -> None:
    raw = replace(gaussians(60), colors=gaussians(60).colors.clip(0, 1))
    splats, path = raw.splats(), tmp_path / "a.glb"
    theirs = GaussianSet(
        positions=splats.means,
        scales=splats.scales,
        rotations=unit_quats(splats.quats)[:, [1, 2, 3, 0]],
        colors=np.concatenate([splats.colors, splats.opacities[:, None]], axis=1),
        motions=np.zeros((60, 3), np.float32),
        mu_t=np.zeros(60),
        sigma_t=np.full(60, np.inf),
        win_lo=np.zeros(60),
        win_hi=np.ones(60),
    )
    to_gltf(str(path), theirs, 0.0, cutoff=0.05, coordinate_system=axes)
    up = np.eye(3) if axes.startswith("y") else np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    same(read_splats(path), raw, TO_OURS @ up)
    assert is_named_as_splats(path)


def test_nodes_within_each_other_move_turn_and_scale() -> None:
    raw = gaussians(40)
    document, binary = plain(raw)
    turn = matrix(TURN)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = 2 * turn, (1, 2, 3)
    x, y, z, w = TURN[[1, 2, 3, 0]]
    document["nodes"] = [
        {"mesh": 0, "matrix": pose.T.ravel().tolist()},
        {"children": [0], "rotation": [x, y, z, w], "scale": [3, 3, 3], "translation": [10, 0, 0]},
    ]
    document["scenes"][0]["nodes"] = [1]
    file = read_glb_splats(packed(document, binary))
    whole = TO_OURS @ turn @ turn
    offset = TO_OURS @ (3 * turn @ [1, 2, 3] + [10, 0, 0])
    moved = replace(file, raw=replace(file.raw, means=(file.raw.means - offset).astype(np.float32)))
    same(moved, raw, whole, 6.0)


def test_colours_by_direction_and_several_meshes_are_kept() -> None:
    first, second = gaussians(30, 3), gaussians(20, 15, seed=1)
    (document, binary), (other, more) = plain(first), plain(second)
    assert read_glb_splats(packed(document, binary)).raw.harmonics.shape == (30, 3, 3)
    shifted = copy.deepcopy(other)
    for view in shifted["bufferViews"]:
        view["byteOffset"] += len(binary)
    count = len(document["accessors"])
    for accessor in shifted["accessors"]:
        accessor["bufferView"] += count
    primitive = shifted["meshes"][0]["primitives"][0]
    primitive["attributes"] = {name: at + count for name, at in primitive["attributes"].items()}
    document["accessors"] += shifted["accessors"]
    document["bufferViews"] += shifted["bufferViews"]
    document["meshes"][0]["primitives"] += [{"attributes": {"POSITION": 0}}, primitive]
    raw = read_glb_splats(packed(document, binary + more)).raw
    assert raw.harmonics.shape == (50, 15, 3)
    assert np.allclose(raw.means[:30] * UP, first.means, atol=1e-4)
    assert np.allclose(raw.means[30:] * UP, second.means, atol=1e-4)
    assert np.allclose(np.abs(raw.harmonics[30:]), np.abs(second.harmonics), atol=1e-6)
    assert not raw.harmonics[:30, 3:].any()


def test_rounded_and_interleaved_attributes_are_read() -> None:
    raw = gaussians(25)
    document, binary = plain(raw)
    opacity = np.rint(255 / (1 + np.exp(-raw.opacity_logits))).astype(np.uint8)
    mixed = np.zeros((25, 8), np.uint8)
    mixed[:, 2] = opacity
    place = document["meshes"][0]["primitives"][0]["attributes"][f"{NAME}:OPACITY"]
    view = {"buffer": 0, "byteOffset": len(binary), "byteLength": 200, "byteStride": 8}
    document["bufferViews"].append(view)
    document["accessors"][place] |= {
        "bufferView": len(document["bufferViews"]) - 1,
        "byteOffset": 2,
        "componentType": 5121,
        "normalized": True,
    }
    file = read_glb_splats(packed(document, binary + mixed.tobytes()))
    assert np.allclose(file.raw.splats().opacities, opacity / 255, atol=1e-6)


@pytest.mark.parametrize(
    "name", ["KHR_gaussian_splatting_compression_spz", "KHR_gaussian_splatting_compression_spz_2"]
)
@pytest.mark.parametrize("mode", ["default", "mip"])
def test_spz_within_is_unpacked(name: str, mode: RenderMode) -> None:
    raw = gaussians(30)
    document, _ = plain(raw)
    blob = spz_bytes(raw, mode)
    primitive = document["meshes"][0]["primitives"][0]
    primitive["extensions"][NAME]["extensions"] = {name: {"bufferView": 0}}
    document["bufferViews"] = [{"buffer": 0, "byteLength": len(blob)}]
    file = read_glb_splats(packed(document, blob))
    # An SPZ file is in right, up, back, too: nothing is turned.
    assert np.allclose(file.raw.means, raw.means, atol=0.01)
    assert np.allclose(file.raw.log_scales, raw.log_scales, atol=1 / 16)
    assert (file.mode, file.notices) == (mode, read_spz(blob).notices)


def test_colours_of_another_space_are_told() -> None:
    document, binary = plain(gaussians(5))
    assert read_glb_splats(packed(document, binary)).notices == ()
    told = document["meshes"][0]["primitives"][0]["extensions"][NAME]
    told["colorSpace"] = "lin_rec709_display"
    (said,) = read_glb_splats(packed(document, binary)).notices
    assert "blended as light" in said


def with_scales(raw: RawGaussians, scales: np.ndarray) -> bytes:
    """The file with these in place of its sizes."""
    document, binary = plain(raw)
    place = document["meshes"][0]["primitives"][0]["attributes"][f"{NAME}:SCALE"]
    start, size = (document["bufferViews"][place][name] for name in ("byteOffset", "byteLength"))
    content = np.ascontiguousarray(scales, np.float32).tobytes()
    return packed(document, binary[:start] + content + binary[start + size :])


def test_logarithms_of_sizes_as_a_draft_had_them_are_read_and_told() -> None:
    """As splat-transform wrote them before June 2026."""
    raw = replace(gaussians(40), log_scales=gaussians(40).log_scales - 2)
    assert 0.5 < (raw.log_scales < 0).mean() < 1, "some are larger than a metre"
    file = read_glb_splats(with_scales(raw, raw.log_scales))
    same(file, raw)
    assert file.notices == ("sizes below 0 are read as logarithms, which older programs wrote into glTF",)
    assert read_glb_splats(with_scales(raw, np.exp(raw.log_scales))).notices == ()


def test_a_few_negative_sizes_are_no_logarithms_and_are_refused() -> None:
    raw = gaussians(40)
    sizes = np.exp(raw.log_scales)
    sizes[3, 1] = -0.01
    with pytest.raises(SplatFileError, match="sizes of 0 or more in the glTF file, got 1 of 120"):
        read_glb_splats(with_scales(raw, sizes))


Change = dict[str, Any]


@pytest.mark.parametrize(
    ("node", "primitive", "buffer", "said"),
    [
        ({"scale": [1, 2, 1]}, {}, {}, "skews or mirrors"),
        ({"scale": [-1, 1, 1]}, {}, {}, "skews or mirrors"),
        ({"rotation": [0.5, 0.5, 0.5, 0.5]}, {}, {}, "does not turn them"),
        ({}, {"kernel": "customShape"}, {}, "got customShape"),
        ({}, {"extensions": {"EXT_other": {}}}, {}, "got EXT_other"),
        ({}, {}, {"uri": "a.bin"}, "names other files"),
    ],
)
def test_what_is_not_read_is_named(node: Change, primitive: Change, buffer: Change, said: str) -> None:
    document, binary = plain(gaussians(20, 3), **node)
    document["meshes"][0]["primitives"][0]["extensions"][NAME] |= primitive
    document["buffers"][0] |= buffer
    with pytest.raises(SplatFileError, match=said):
        read_glb_splats(packed(document, binary))


@pytest.mark.parametrize("name", ["POSITION", f"{NAME}:SH_DEGREE_0_COEF_0", f"{NAME}:SCALE"])
def test_an_attribute_that_is_missing_is_named(name: str) -> None:
    document, binary = plain(gaussians(20))
    del document["meshes"][0]["primitives"][0]["attributes"][name]
    with pytest.raises(SplatFileError, match=f"expected splats with {name} in"):
        read_glb_splats(packed(document, binary))


def test_an_extension_that_the_file_requires_is_read_or_named() -> None:
    document, binary = plain(gaussians(20))
    document["extensionsRequired"] = [NAME, "KHR_mesh_quantization"]
    assert len(read_glb_splats(packed(document, binary)).raw) == 20
    document["extensionsRequired"].append("EXT_meshopt_compression")
    with pytest.raises(SplatFileError, match="got one that requires EXT_meshopt_compression"):
        read_glb_splats(packed(document, binary))


def test_a_buffer_that_an_extension_is_to_fill_is_not_looked_for_in_another() -> None:
    document, binary = plain(gaussians(20))
    document["bufferViews"][0] |= {"buffer": 1, "extensions": {"EXT_meshopt_compression": {"buffer": 0}}}
    document["buffers"].append({"byteLength": len(binary)})
    with pytest.raises(SplatFileError, match="an array that lies in none of them"):
        read_glb_splats(packed(document, binary))


def test_a_mesh_without_splats_is_told_from_a_damaged_file(tmp_path: Path) -> None:
    document, binary = plain(gaussians(20))
    del document["meshes"][0]["primitives"][0]["extensions"]
    path = tmp_path / "mesh.glb"
    path.write_bytes(packed(document, binary))
    with pytest.raises(SplatFileError, match="got one without any") as caught:
        read_splats(path)
    assert str(path) in str(caught.value)


def test_nodes_without_end_are_refused() -> None:
    document, binary = plain(gaussians(5))
    document["nodes"] = [{"children": [0, 0]}]
    with pytest.raises(SplatFileError, match="damaged"):
        read_glb_splats(packed(document, binary))


def test_damaged_files_are_refused_or_repaired() -> None:
    document, binary = plain(gaussians(12, 3))
    text, whole, refused = json.dumps(document).encode(), packed(document, binary), 0
    for seed in range(1000):
        if seed % 2:
            damaged = mutated(text, seed)
            content = framed(damaged + b" " * (-len(damaged) % 4), binary)
        else:
            content = mutated(whole, seed)
        try:
            read_glb_splats(content)
        except (SplatFileError, OverBudget):
            refused += 1
    assert refused > 300
