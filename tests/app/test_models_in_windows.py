"""A model in windows: rendered, exported and edited as one that is not cut, or refused in a line."""

from __future__ import annotations

import csv
import shutil
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from pxr import Usd, UsdGeom

from app.errors import UserError
from app.exports.records import Tracks
from app.exports.replay.recorded import recorded
from app.exports.research.tracks import write_tracks
from app.files.records import extended
from app.files.stepping import run_to_end
from app.runs.run_edits import save_edits
from app.runs.run_folder import RunFolder
from app.scenes.records import MomentRecord
from app.scenes.scene import Scene, open_scene
from app.scenes.surfaces import moment_of_surface, surface_at
from app.scenes.window_scene import scene_of_window
from renderer.deformation.motion import Still
from renderer.editing.edits import Edits
from renderer.editing.mask import Mask
from renderer.gaussians import DynamicGaussians
from renderer.model_windows import windows_of
from renderer.surface.fineness import Fineness
from tests.app.conftest import Cli
from tests.app.exports.test_meshes import parts
from tests.app.exports.test_research import Drift, slope
from tests.renderer.windowed import windowed

FIRST, LATER = 4, 107
"""Frames of the first window and of the last one."""


@pytest.fixture
def run(windowed_run: Path, tmp_path: Path) -> Path:
    """One that a test may edit."""
    return Path(shutil.copytree(windowed_run, tmp_path / "run"))


def picture(path: Path) -> np.ndarray:
    image = cv2.imread(str(path))
    assert image is not None
    return image


def test_motion_and_surface_are_rendered_and_come_again(
    windowed_run: Path, vesselsplat: Cli, tmp_path: Path
) -> None:
    assert len(windows_of(open_scene(windowed_run).model)) == 3
    for view in ("motion", "surface"):
        out = tmp_path / view
        done = vesselsplat("render", windowed_run, "--out", out, "--view", view, "--frames", FIRST, LATER)
        assert done.code == 0, done.error
        first, later = (picture(out / f"frame-{frame:06d}.png") for frame in (FIRST, LATER))
        assert first.std() > 5 < later.std()
        again = vesselsplat("replay", out / f"frame-{LATER:06d}.png", "--source", windowed_run)
        assert again.out.rstrip().endswith("identical"), again.error + again.out


def test_the_surface_of_each_moment_is_that_of_its_window(
    windowed_run: Path, vesselsplat: Cli, tmp_path: Path
) -> None:
    scene, out, fineness = open_scene(windowed_run), tmp_path / "meshes", Fineness(vertices=2000)
    flags = ("--mesh-format", "obj", "--frames", FIRST, LATER, "--vertices", fineness.vertices)
    done = vesselsplat("export", windowed_run, "--mesh", out, *flags)
    assert done.code == 0, done.error
    assert "2 meshes, the first of" in done.out
    for frame in (FIRST, LATER):
        text = (out / f"frame-{frame:06d}.obj").read_text().splitlines()
        vertices = np.array([line.split()[1:4] for line in text if line.startswith("v ")], float)
        camera = scene.cameras[frame]
        pixels, depths = camera.project(vertices)
        inside = ((pixels > 2) & (pixels < [camera.width - 2, camera.height - 2])).all(axis=1)
        assert inside.mean() > 0.5
        seen = moment_of_surface(scene, scene.time(frame), fineness)
        assert len(seen.vertices) > 500
        assert np.median(depths[inside]) == pytest.approx(60, rel=0.15)  # The phantom's tissue, in mm.


def drifting(scene: Scene) -> tuple[Scene, np.ndarray]:
    """A known surface that goes along `way` in each of three windows, and begins again where it ended."""
    way, raw, ends, frames = np.array([1.5, -1.0, 2.0]), slope(scene), ((0, 39), (24, 75), (60, 99)), 100
    parts = []
    for first, last in ends:
        length = (last - first + 1) / frames
        began = replace(raw, means=(raw.means + first / frames * way).astype(np.float32))
        parts.append((first, last, DynamicGaussians(began, Drift(tuple(length * way)))))
    cameras = (scene.cameras[0],) * frames
    return replace(scene, model=windowed(frames, *parts), cameras=cameras), way


@pytest.mark.parametrize("start", [0.0, 0.5, 0.99])
def test_points_are_followed_from_window_to_window(windowed_run: Path, tmp_path: Path, start: float) -> None:
    scene, way = drifting(open_scene(windowed_run))
    camera, path, points = scene.cameras[0], tmp_path / "a.csv", ((20, 20), (40, 30))
    times = (0.0, 0.2, 0.33, 0.5, 0.68, 0.9, 0.99)
    moments = tuple(MomentRecord(time=time, camera=camera, near=0.1) for time in times)
    begun = MomentRecord(time=start, camera=camera, near=0.1)
    record = extended(Tracks, scene.record, points=points, start=begun, moments=moments)
    run_to_end(write_tracks(record, scene, path))
    rows = list(csv.DictReader(path.read_text().splitlines()))
    places = np.array([[float(row[axis]) for axis in "xyz"] for row in rows]).reshape(2, len(times), 3)
    gone = places - places[:, :1]
    assert np.abs(gone - np.outer(times, way)).max() < 0.35
    assert {row["seen"] for row in rows} == {"1"}
    for place, (column, line) in zip(places, points, strict=True):
        at_start = place[0] + start * way
        pixel, _ = camera.project(at_start[None])
        assert np.abs(pixel[0] - [column + 0.5, line + 0.5]).max() < 0.6


def test_points_that_the_next_window_does_not_see_stay(windowed_run: Path, tmp_path: Path) -> None:
    scene, _ = drifting(open_scene(windowed_run))
    whole = scene.model
    bare = whole.rows(np.arange(windows_of(whole)[0].rows.stop))
    scene = replace(scene, model=bare)
    camera, path = scene.cameras[0], tmp_path / "a.csv"
    moments = tuple(MomentRecord(time=time, camera=camera, near=0.1) for time in (0.0, 0.3, 0.5, 0.9))
    record = extended(Tracks, scene.record, points=((20, 20),), start=moments[0], moments=moments)
    run_to_end(write_tracks(record, scene, path))
    rows = list(csv.DictReader(path.read_text().splitlines()))
    assert [row["seen"] for row in rows] == ["1", "1", "0", "0"]
    assert rows[2]["x"] == rows[3]["x"]


def test_edits_are_kept_beside_the_run_and_hold_in_every_window(
    run: Path, vesselsplat: Cli, tmp_path: Path
) -> None:
    scene = open_scene(run)
    gone = Mask.of(np.arange(len(scene.model)) < windows_of(scene.model)[0].rows.stop)
    edits = Edits.none(len(scene.model)).selecting(gone, "replace").deleting()
    save_edits(RunFolder(run), edits)
    assert "are removed" in open_scene(run).notices[0]
    for flags, name in (((), "edited"), (("--as-trained",), "trained")):
        out = tmp_path / name
        done = vesselsplat(
            "render", run, "--out", out, "--frames", FIRST, LATER, "--background", "black", *flags
        )
        assert done.code == 0, done.error
    edited, whole = (
        [picture(tmp_path / name / f"frame-{at:06d}.png") for at in (FIRST, LATER)]
        for name in ("edited", "trained")
    )
    assert edited[0].max() == 0
    assert np.array_equal(edited[1], whole[1])
    again = vesselsplat("replay", tmp_path / "edited" / f"frame-{FIRST:06d}.png", "--source", run)
    assert again.out.rstrip().endswith("identical"), again.error + again.out
    told = recorded(tmp_path / "edited" / f"frame-{FIRST:06d}.png")
    assert told["edits"]["n_deleted"] == len(gone)


def test_a_run_that_does_not_move_has_a_surface_at_once(windowed_run: Path) -> None:
    scene = open_scene(windowed_run)
    still = replace(scene, model=DynamicGaussians(slope(scene), Still()))
    assert len(surface_at(still, 0.9).faces) > 100


@pytest.mark.parametrize(("flag", "name"), [("--html", "a.html"), ("--npz", "a.npz"), ("--mesh", "a.glb")])
def test_one_window_is_exported_as_a_model_of_its_own(
    windowed_run: Path, vesselsplat: Cli, tmp_path: Path, flag: str, name: str
) -> None:
    path, few = tmp_path / name, ("--vertices", 500) if flag == "--mesh" else ()
    done = vesselsplat("export", windowed_run, flag, path, "--window", 2, *few)
    assert done.code == 0, done.error
    assert recorded(path)["window"] == 2
    again = vesselsplat("replay", path, "--source", windowed_run)
    assert again.out.rstrip().endswith("identical"), again.error + again.out


def test_a_window_alone_is_where_it_is_in_the_whole(windowed_run: Path) -> None:
    whole = open_scene(windowed_run)
    windows = windows_of(whole.model)
    assert {index for window in windows for index in window.frames(112)} == set(range(112))
    for number, window in enumerate(windows, start=1):
        one = scene_of_window(whole, number)
        frames = window.frames(112)
        middle = frames[len(frames) // 2]
        assert not one.split_by_time
        assert one.number_at(one.time(middle - frames.start)) == middle + 1
        assert one.cameras[middle - frames.start] == whole.cameras[middle]
        alone, beside = one.model.at(one.time(middle - frames.start)), whole.model.at(whole.time(middle))
        assert np.allclose(alone.means, beside.means, atol=1e-4)
        assert [index + frames.start for index in one.test_indices] == [
            index for index in whole.test_indices if index in frames
        ]


def test_no_other_window_is_there(windowed_run: Path, vesselsplat: Cli, tmp_path: Path) -> None:
    out = tmp_path / "out"
    for number in (0, 4):
        refused = vesselsplat("render", windowed_run, "--out", out, "--window", number)
        assert (refused.code, out.exists()) == (2, False)
        assert f"expected a window from 1 to 3, got {number}" in refused.error
    compared = vesselsplat("render", windowed_run, "--out", out, "--window", 1, "--view", "difference")
    assert (compared.code, out.exists()) == (2, False)
    assert "--view difference" in compared.error
    uncut = replace(open_scene(windowed_run), model=windows_of(open_scene(windowed_run).model)[0].model)
    with pytest.raises(UserError, match="not cut"):
        scene_of_window(uncut, 1)


def test_a_window_is_that_of_the_edited_model(run: Path, vesselsplat: Cli, tmp_path: Path) -> None:
    scene = open_scene(run)
    half = Mask.of(np.arange(len(scene.model)) % 2 == 0)
    save_edits(RunFolder(run), Edits.none(len(scene.model)).selecting(half, "replace").deleting())
    edited = open_scene(run)
    assert len(scene_of_window(edited, 2).model) == pytest.approx(
        len(scene_of_window(scene, 2).model) / 2, abs=1
    )
    path = tmp_path / "a.npz"
    assert vesselsplat("export", run, "--npz", path, "--window", 2, "--frames", 0, 5).code == 0
    again = vesselsplat("replay", path, "--source", run)
    assert again.out.rstrip().endswith("identical"), again.error + again.out
    first = Mask.of(np.arange(len(scene.model)) < windows_of(scene.model)[0].rows.stop)
    bare = scene.edited(Edits.none(len(scene.model)).selecting(first, "replace").deleting())
    with pytest.raises(UserError, match="got none; maybe all were removed"):
        scene_of_window(bare, 1)


def test_a_mesh_file_leaves_out_a_window_whose_gaussians_are_removed(
    run: Path, vesselsplat: Cli, tmp_path: Path
) -> None:
    scene = open_scene(run)
    windows = windows_of(scene.model)
    first = Mask.of(np.arange(len(scene.model)) < windows[0].rows.stop)
    save_edits(RunFolder(run), Edits.none(len(scene.model)).selecting(first, "replace").deleting())
    done = vesselsplat("export", run, "--mesh", tmp_path / "a.glb", "--vertices", 500)
    assert (done.code, f"{len(windows) - 1} meshes, one after the other" in done.out) == (0, True), done.error


def test_the_mesh_of_the_only_window_that_is_left_is_shown_at_its_frames_alone(
    run: Path, vesselsplat: Cli, tmp_path: Path
) -> None:
    scene = open_scene(run)
    rows = np.arange(len(scene.model))
    middle = windows_of(scene.model)[1].rows
    others = Mask.of((rows < middle.start) | (rows >= middle.stop))
    save_edits(RunFolder(run), Edits.none(len(rows)).selecting(others, "replace").deleting())
    for name in ("a.glb", "a.usdc"):
        assert vesselsplat("export", run, "--mesh", tmp_path / name, "--vertices", 500).code == 0
    document, arrays = parts(tmp_path / "a.glb")
    (animation,) = document["animations"]
    (scale,) = (one for one in animation["channels"] if one["target"]["path"] == "scale")
    sampler = animation["samplers"][scale["sampler"]]
    moments, sizes = arrays[sampler["input"]], arrays[sampler["output"]]
    np.testing.assert_allclose(moments[:, 0] * 15, [0, 40, 72], atol=1e-4)
    assert sizes[:, 0].tolist() == [0, 1, 0]
    stage = Usd.Stage.Open(str(tmp_path / "a.usdc"))
    (mesh,) = stage.GetDefaultPrim().GetChildren()
    invisible = [
        frame for frame in range(112) if UsdGeom.Imageable(mesh).ComputeVisibility(frame) != "inherited"
    ]
    assert invisible == [*range(40), *range(72, 112)]
    del stage, mesh


def test_a_missing_surface_is_told_with_its_window_before_any_file_is_written(
    run: Path, vesselsplat: Cli, tmp_path: Path
) -> None:
    scene, out = open_scene(run), tmp_path / "out"
    last = Mask.of(np.arange(len(scene.model)) >= windows_of(scene.model)[2].rows.start)
    save_edits(RunFolder(run), Edits.none(len(scene.model)).selecting(last, "replace").deleting())
    flags = ("--frames", 2, 100, "--npz", out / "a.npz", "--ply", out / "ply", "--vertices", 500)
    done = vesselsplat("export", run, *flags, "--mesh", out / "meshes")
    assert done.code == 2
    assert "expected a surface in window 3, frames 64 to 111, got none" in done.error
    assert "the window is empty; maybe all was removed" in done.error
    assert not out.exists()
    every = Edits.none(len(scene.model)).selecting(Mask.of(np.ones(len(scene.model), bool)), "replace")
    save_edits(RunFolder(run), every.deleting())
    done = vesselsplat("export", run, "--cameras", out / "a.json", "--mesh", out / "a.glb")
    assert (done.code, "expected a surface in window 1, frames 0 to " in done.error) == (2, True)
    assert not out.exists()
