"""The tissue surface as files: what other programs read there is what the model shows, at every moment."""

from __future__ import annotations

import random
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from pxr import Usd, UsdGeom

from app.errors import UserError
from app.exports.gltf import read_glb
from app.exports.meshes.film import straight_parts
from app.exports.usd_file import read_usd
from app.scenes.scene import open_scene
from app.scenes.surfaces import moment_of_surface, surface
from renderer.surface.fineness import Fineness
from renderer.surface.following import Follower
from tests.app.conftest import Cli

FINENESS = Fineness(vertices=500)


@pytest.fixture(scope="module")
def follower(runs: dict[str, Path]) -> Follower:
    return surface(open_scene(runs["original"]), FINENESS)


@pytest.fixture(scope="module")
def written(runs: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    from app.__main__ import main

    path = tmp_path_factory.mktemp("meshes") / "surface.glb"
    assert main(["export", str(runs["original"]), "--mesh", str(path), "--vertices", "500"]) == 0
    return path


def in_metres(vertices: np.ndarray) -> np.ndarray:
    return vertices * np.array([1, -1, -1]) / 1000


def test_trimesh_reads_the_surface_of_the_first_frame_in_metres_and_y_up(
    written: Path, follower: Follower
) -> None:
    (mesh,) = trimesh.load_scene(written).geometry.values()
    own = follower.at(0.0)
    assert mesh.faces.tolist() == own.faces.tolist()
    assert np.abs(mesh.vertices - in_metres(own.vertices)).max() < 1e-7
    texture = np.asarray(mesh.visual.material.baseColorTexture)
    # Of glTF, v runs down; trimesh turns it up.
    places = mesh.visual.uv * [1, -1] + [0, 1]
    row, column = (places[:, ::-1] * np.array(texture.shape[:2]) - 0.5).round().astype(int).T
    assert np.abs(texture[row, column, :3] / 255 - follower.mesh.colors).mean() < 0.03


def test_morph_targets_pass_through_the_surface_of_every_frame(
    written: Path, follower: Follower, runs: dict[str, Path]
) -> None:
    """Blended by the rules of glTF, from the arrays of the file alone."""
    scene = open_scene(runs["original"])
    document, arrays = parts(written)
    (primitive,) = document["meshes"][0]["primitives"]
    base = arrays[primitive["attributes"]["POSITION"]]
    ways = [arrays[target["POSITION"]] for target in primitive["targets"]]
    (sampler,) = document["animations"][0]["samplers"]
    moments = arrays[sampler["input"]][:, 0]
    weights = arrays[sampler["output"]].reshape(len(moments), len(ways))
    assert moments[-1] == pytest.approx(9 / 15)
    for frame in range(10):
        now = [np.interp(frame / 15, moments, weights[:, target]) for target in range(len(ways))]
        shown = base + np.einsum("t,tvc->vc", now, np.array(ways))
        away = np.linalg.norm(shown - in_metres(follower.at(scene.time(frame)).vertices), axis=1)
        assert away.max() < 6e-4 * scene.distance / 1000


SHOWN = ((0, range(40)), (1, range(40, 72)), (2, range(72, 112)))
"""Windows of the long run, each with the frames at which it shows most."""


@pytest.fixture(scope="module")
def of_windows(windowed_run: Path) -> dict[int, tuple[int, np.ndarray]]:
    """By frame, the window and the vertices that are to be shown."""
    scene = open_scene(windowed_run)
    frames = (0, 20, 39, 41, 60, 71, 73, 100, 111)
    windows = {frame: next(one for one, share in SHOWN if frame in share) for frame in frames}
    return {
        frame: (window, moment_of_surface(scene, scene.time(frame), FINENESS).vertices)
        for frame, window in windows.items()
    }


def test_of_a_long_clip_the_mesh_of_each_window_has_its_turn_in_one_file(
    windowed_run: Path,
    of_windows: dict[int, tuple[int, np.ndarray]],
    vesselsplat: Cli,
    tmp_path: Path,
) -> None:
    """Shown and blended by the rules of glTF, from the arrays of the file alone."""
    path, scene = tmp_path / "a.glb", open_scene(windowed_run)
    done = vesselsplat("export", windowed_run, "--mesh", path, "--vertices", 500)
    assert (done.code, "3 meshes, one after the other" in done.out) == (0, True), done.error
    document, arrays = parts(path)
    (animation,) = document["animations"]
    channels = {
        (one["target"]["node"], one["target"]["path"]): animation["samplers"][one["sampler"]]
        for one in animation["channels"]
    }
    assert [node.get("scale", [1, 1, 1]) for node in document["nodes"]] == [[1] * 3, [0] * 3, [0] * 3]
    for frame, (window, vertices) in of_windows.items():
        time = frame / 15 + 1e-4
        sizes = []
        for node in range(3):
            scale = channels[node, "scale"]
            at = max(np.searchsorted(arrays[scale["input"]][:, 0], time, side="right") - 1, 0)
            sizes.append(arrays[scale["output"]][at].tolist())
        assert sizes == [[float(node == window)] * 3 for node in range(3)], frame
        (primitive,) = document["meshes"][document["nodes"][window]["mesh"]]["primitives"]
        ways = np.array([arrays[target["POSITION"]] for target in primitive["targets"]])
        sampler = channels[window, "weights"]
        moments, values = arrays[sampler["input"]][:, 0], arrays[sampler["output"]].reshape(-1, len(ways))
        now = [np.interp(frame / 15, moments, values[:, target]) for target in range(len(ways))]
        shown = arrays[primitive["attributes"]["POSITION"]] + np.einsum("t,tvc->vc", now, ways)
        away = np.linalg.norm(shown - in_metres(vertices), axis=1)
        assert away.max() < 6e-4 * scene.distance / 1000
    assert len(trimesh.load_scene(path).geometry) == 3
    again = vesselsplat("replay", path, "--source", windowed_run)
    assert again.out.rstrip().endswith("identical"), again.error + again.out


def test_usd_shows_the_mesh_of_each_window_in_its_turn(
    windowed_run: Path,
    of_windows: dict[int, tuple[int, np.ndarray]],
    vesselsplat: Cli,
    tmp_path: Path,
) -> None:
    path, scene = tmp_path / "a.usdc", open_scene(windowed_run)
    done = vesselsplat("export", windowed_run, "--mesh", path, "--vertices", 500)
    assert done.code == 0, done.error
    stage = Usd.Stage.Open(str(path))
    meshes = [UsdGeom.Mesh(prim) for prim in stage.GetDefaultPrim().GetChildren()]
    for frame, (window, vertices) in of_windows.items():
        hidden = [mesh.ComputeVisibility(frame) == UsdGeom.Tokens.invisible for mesh in meshes]
        assert hidden == [place != window for place in range(3)], frame
        shown = np.array(meshes[window].GetPointsAttr().Get(frame)) * [1, -1, -1]
        assert np.linalg.norm(shown - vertices, axis=1).max() < 6e-4 * scene.distance
    del stage, meshes
    again = vesselsplat("replay", path, "--source", windowed_run)
    assert again.out.rstrip().endswith("identical"), again.error + again.out


def parts(path: Path) -> tuple[Any, list[np.ndarray]]:
    from renderer.json_files import parsed

    content = path.read_bytes()
    size = int.from_bytes(content[12:16], "little")
    return parsed(content[20 : 20 + size].decode()), read_glb(path)[1]


@pytest.mark.parametrize("form", ["ply", "obj"])
def test_a_mesh_per_frame_is_read_by_trimesh_and_reproduced(
    form: str, runs: dict[str, Path], follower: Follower, vesselsplat: Cli, tmp_path: Path
) -> None:
    run, folder = runs["original"], tmp_path / "meshes"
    flags = ("--mesh-format", form, "--vertices", 500, "--frames", 0, 7)
    done = vesselsplat("export", run, "--mesh", folder, *flags)
    assert done.code == 0, done.error
    assert sorted(path.name for path in folder.iterdir()) == [f"frame-00000{at}.{form}" for at in (0, 7)]
    own = follower.at(0.7)
    mesh = trimesh.load_mesh(folder / f"frame-000007.{form}", process=False, maintain_order=True)
    assert np.abs(mesh.vertices - own.vertices).max() < 1e-5
    assert mesh.faces.tolist() == own.faces.tolist()
    colors = mesh.visual.vertex_colors[:, :3] / 255
    assert np.abs(colors - own.colors).max() < 1 / 255
    again = vesselsplat("replay", folder / f"frame-000007.{form}", "--source", run)
    assert again.out.rstrip().endswith("identical"), again.error + again.out
    assert "surface mesh" in vesselsplat("info", folder / f"frame-000007.{form}").out


@pytest.mark.parametrize("start", ["v ", "vn ", "f "])
def test_a_changed_line_of_an_obj_is_found_out(
    start: str, runs: dict[str, Path], vesselsplat: Cli, tmp_path: Path
) -> None:
    flags = ("--mesh-format", "obj", "--vertices", 500, "--frames", 0)
    done = vesselsplat("export", runs["original"], "--mesh", tmp_path / "meshes", *flags)
    assert (done.code, f"{tmp_path / 'meshes'}: 1 mesh of " in done.out) == (0, True)
    path = tmp_path / "meshes" / "frame-000000.obj"
    lines = path.read_text().splitlines()
    first, second = [place for place, line in enumerate(lines) if line.startswith(start)][:2]
    for changed, said in ((lines[second], " differs in "), (f"{start}1 2", "expected an OBJ mesh")):
        path.write_text("\n".join([*lines[:first], changed, *lines[first + 1 :], ""]))
        again = vesselsplat("replay", path, "--source", runs["original"])
        assert said in again.out + again.error
        assert again.code == 2


def test_the_file_says_what_it_is_of_and_comes_again(
    written: Path, runs: dict[str, Path], vesselsplat: Cli
) -> None:
    facts, _ = read_glb(written)
    assert (facts["kind"], facts["run"]["name"], facts["vertices"]) == ("surface mesh", "original", 500)
    assert str(written.parent).encode() not in written.read_bytes()
    again = vesselsplat("replay", written, "--source", runs["original"])
    assert again.out.rstrip().endswith("identical"), again.error + again.out


def test_usd_core_reads_the_surface_of_every_frame(
    runs: dict[str, Path], follower: Follower, vesselsplat: Cli, tmp_path: Path
) -> None:
    scene, path = open_scene(runs["original"]), tmp_path / "surface.usdc"
    done = vesselsplat("export", runs["original"], "--mesh", path, "--vertices", 500)
    assert done.code == 0, done.error
    stage = Usd.Stage.Open(str(path))
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.001
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert (stage.GetTimeCodesPerSecond(), stage.GetEndTimeCode()) == (15, 9)
    mesh = UsdGeom.Mesh(stage.GetDefaultPrim())
    for frame in range(10):
        own = follower.at(scene.time(frame))
        shown = np.array(mesh.GetPointsAttr().Get(frame))
        assert np.linalg.norm(shown * [1, -1, -1] - own.vertices, axis=1).max() < 6e-4 * scene.distance
    assert np.array(mesh.GetFaceVertexIndicesAttr().Get()).tolist() == follower.mesh.faces.ravel().tolist()
    del stage, mesh
    again = vesselsplat("replay", path, "--source", runs["original"])
    assert again.out.rstrip().endswith("identical"), again.error + again.out
    assert "surface mesh" in vesselsplat("info", path).out
    content, drawn = path.read_bytes(), random.Random(0)
    for _ in range(100):
        damaged = bytearray(content)
        for _ in range(drawn.randrange(1, 8)):
            damaged[-drawn.randrange(1, 900)] = drawn.randrange(256)
        path.write_bytes(damaged)
        with suppress(UserError):
            read_usd(path)
    path.write_bytes(content[:200])
    cut = vesselsplat("replay", path, "--source", runs["original"])
    assert (cut.code, cut.error.count("\n")) == (2, 1)


def test_bad_wishes_are_one_line(
    runs: dict[str, Path], vesselsplat: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = runs["original"]
    for flags, said in (
        (("--mesh", tmp_path / "a.stl"), "--mesh: expected a .glb or .usdc file, or a folder, got a.stl"),
        (("--mesh", tmp_path / "a.glb", "--faces", 3), "--faces: expected at least 50, got 3"),
        (("--mesh", tmp_path / "a.glb", "--vertices", 1), "--vertices: expected 100 to 2000000, got 1"),
    ):
        done = vesselsplat("export", run, *flags)
        assert (done.code, done.error.count("\n")) == (2, 1)
        assert said in done.error
    monkeypatch.setitem(__import__("sys").modules, "fast_simplification", None)
    done = vesselsplat("export", run, "--mesh", tmp_path / "a.glb", "--faces", 50)
    assert done.code == 2
    assert "pip install fast-simplification" in done.error
    monkeypatch.setitem(__import__("sys").modules, "pxr", None)
    done = vesselsplat("export", run, "--mesh", tmp_path / "a.usdc")
    assert done.code == 2
    assert "pip install usd-core" in done.error


def test_a_damaged_file_is_refused_in_one_line(written: Path, tmp_path: Path) -> None:
    content, drawn = written.read_bytes(), random.Random(0)
    size, path = int.from_bytes(content[12:16], "little"), tmp_path / "a.glb"
    for _ in range(1000):
        damaged = bytearray(content[: 20 + size + 4000] if drawn.random() < 0.5 else content)
        for _ in range(drawn.randrange(1, 6)):
            damaged[drawn.randrange(20 + size)] = drawn.randrange(256)
        path.write_bytes(damaged)
        with suppress(UserError):
            read_glb(path)
    path.write_bytes(content[:-1])
    with pytest.raises(UserError, match=r"expected a GLB file written by VesselSplat \(.*\): .*a\.glb$"):
        read_glb(path)


def test_moments_between_which_all_goes_straight_are_few() -> None:
    way = np.concatenate([np.linspace(0, 1, 6), np.linspace(1, -1, 5)[1:]])
    positions = np.zeros((len(way), 4, 3), np.float32)
    positions[:, 2, 1] = way
    assert straight_parts(positions, 1e-3) == [0, 5, 9]
    assert straight_parts(positions[:1], 1e-3) == [0]
