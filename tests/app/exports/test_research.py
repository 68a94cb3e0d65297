"""Arrays, tables, depth and cameras for research, as numpy, OpenCV and the csv module read them."""

from __future__ import annotations

import csv
import json
import random
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, Self

import cv2
import numpy as np
import pytest

from app.errors import UserError
from app.exports.records import Tracks
from app.exports.replay.difference import arrays
from app.exports.replay.recorded import recorded
from app.exports.research.tracks import COLUMNS, write_tracks
from app.files.records import extended
from app.files.stepping import run_to_end
from app.scenes.records import MomentRecord
from app.scenes.scene import Scene, open_scene
from app.scenes.window_scene import scene_of_window
from renderer.camera_files import read_cameras
from renderer.gaussians import DynamicGaussians
from renderer.raw_gaussians import RawGaussians
from renderer.rotations import unit_quats
from renderer.splats import Splats
from renderer.stored_arrays import Arrays
from tests.app.conftest import Cli


@pytest.fixture(scope="module")
def scene(runs: dict[str, Path]) -> Scene:
    return open_scene(runs["original"])


def named(splats: Splats) -> dict[str, np.ndarray]:
    """As the file has them."""
    return {
        "positions": splats.means, "rotations": unit_quats(splats.quats), "scales": splats.scales,
        "opacities": splats.opacities, "colors": splats.colors,
    }  # fmt: skip


def test_arrays_are_those_of_the_model_at_each_moment(
    runs: dict[str, Path], scene: Scene, vesselsplat: Cli, tmp_path: Path
) -> None:
    run, path = runs["original"], tmp_path / "a.npz"
    done = vesselsplat("export", run, "--npz", path, "--frames", 0, 4, 9)
    assert (done.code, done.error) == (0, "")
    file = dict(np.load(path, allow_pickle=False))
    names = [name for name in file if name not in ("README", "provenance")]
    page = file["README"].item().decode()
    assert len(names) == 10
    for name in names:
        shape = ", ".join(map(str, file[name].shape)) + ("," if file[name].ndim == 1 else "")
        assert f"\n{name} ({shape}) {file[name].dtype}: " in page
    assert file["frame_numbers"].tolist() == [0, 4, 9]
    assert file["positions"].shape == (3, len(scene.model), 3)
    for place, frame in enumerate((0, 4, 9)):
        for name, values in named(scene.model.at(scene.time(frame))).items():
            rows = file[name]
            assert (rows[place if len(rows) > 1 else 0] == values).all(), name
        assert np.allclose(np.linalg.norm(file["rotations"][0], axis=1), 1, atol=1e-6)
        assert (file["camera_from_world"][place] == scene.cameras[frame].camera_from_world).all()
    rendered = vesselsplat("render", run, "--out", tmp_path, "--frames", 4, "--depth")
    assert rendered.code == 0, rendered.error
    whole, seen = np.load(tmp_path / "frame-000004-depth.npy"), file["depth"][1] > 0
    assert seen.mean() > 0.5
    assert (whole[seen] == file["depth"][1][seen]).all()
    again = vesselsplat("replay", path, "--source", run)
    assert again.out.rstrip().endswith("identical"), again.error + again.out
    assert "model arrays" in vesselsplat("info", path).out


def test_frames_and_times_of_one_window_are_told_as_its_own(
    windowed_run: Path, vesselsplat: Cli, tmp_path: Path
) -> None:
    window = ("--window", 2, "--frames", 0, 5)
    start = scene_of_window(open_scene(windowed_run), 2).start
    assert start > 0
    own = f"of window 2, counted from 0 at frame {start} of the whole clip; "
    done = vesselsplat("export", windowed_run, "--npz", tmp_path / "a.npz", *window)
    assert done.code == 0, done.error
    with np.load(tmp_path / "a.npz") as file:
        page = " ".join(file["README"].item().decode().split())
        assert file["frame_numbers"].tolist() == [0, 5]
    assert own in page
    assert "in [0, 1] over window 2" in page
    done = vesselsplat("export", windowed_run, "--tracks", tmp_path / "a.csv", "--points", "32,24", *window)
    assert done.code == 0, done.error
    told = json.loads((tmp_path / "a.csv.json").read_text())["definitions"]
    assert told["frame"].startswith(own)
    assert told["time"] == "in [0, 1] over window 2"


def test_arrays_of_a_long_clip_are_those_of_each_window_while_it_is_there(
    windowed_run: Path, vesselsplat: Cli, tmp_path: Path
) -> None:
    path, scene, frames = tmp_path / "a.npz", open_scene(windowed_run), (4, 34, 44, 60, 107)
    done = vesselsplat("export", windowed_run, "--npz", path, "--frames", *frames)
    assert (done.code, done.error) == (0, "")
    file = dict(np.load(path, allow_pickle=False))
    there = {number: file[f"window_{number}/moments"].tolist() for number in (1, 2, 3)}
    assert there == {1: [0, 1], 2: [2, 3], 3: [4]}
    assert "window_2/positions (2, " in file["README"].item().decode()
    for place, frame in enumerate(frames):
        for name, values in named(scene.model.at(scene.time(frame))).items():
            parts = []
            for number in (one for one in there if place in there[one]):
                rows = file[f"window_{number}/{name}"]
                parts.append(rows[there[number].index(place) if len(rows) > 1 else 0])
            assert np.array_equal(np.concatenate(parts), values), (frame, name)
    assert file["depth"].shape[0] == len(frames)
    again = vesselsplat("replay", path, "--source", windowed_run)
    assert again.out.rstrip().endswith("identical"), again.error + again.out


def test_a_damaged_file_of_arrays_is_refused(runs: dict[str, Path], vesselsplat: Cli, tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    assert vesselsplat("export", runs["original"], "--npz", path, "--time", 0.5).code == 0
    content, drawn, refused = path.read_bytes(), random.Random(0), 0
    for _ in range(100):
        damaged = bytearray(content[: drawn.randrange(len(content))] if drawn.random() < 0.3 else content)
        for _ in range(drawn.randrange(1, 20)):
            damaged[drawn.randrange(len(damaged))] = drawn.randrange(256)
        path.write_bytes(damaged)
        try:
            list(arrays(path))
            recorded(path)
        except UserError as error:
            refused += str(path) in str(error)
    assert refused == 100


def test_depth_comes_in_whole_steps_and_as_floats_that_opencv_reads(
    runs: dict[str, Path], vesselsplat: Cli, tmp_path: Path
) -> None:
    run = runs["original"]
    for form in ("npy", "tiff", "png16"):
        flags = ("--frames", 3, "--depth", "--depth-format", form)
        assert vesselsplat("render", run, "--out", tmp_path, *flags).code == 0
    alone = vesselsplat("render", run, "--out", tmp_path / "none", "--depth-format", "tiff")
    assert (alone.code, "--depth-format tiff: expected --depth with it" in alone.error) == (2, True)
    exact = np.load(tmp_path / "frame-000003-depth.npy")
    floats = cv2.imread(str(tmp_path / "frame-000003-depth.tiff"), cv2.IMREAD_UNCHANGED)
    assert floats.dtype == np.float32
    assert (floats == exact).all()
    path = tmp_path / "frame-000003-depth16.png"
    whole = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert whole.dtype == np.uint16
    step = recorded(path)["step"]
    assert step == 0.01  # mm, of tissue at 60.
    assert np.abs(whole * step - exact).max() <= 0.501 * step
    again = vesselsplat("replay", path, "--source", run)
    assert again.out.rstrip().endswith("identical"), again.error + again.out


@dataclass(frozen=True)
class Drift:
    """Everything goes along `way` during the clip."""

    NAMES: ClassVar[tuple[str, ...]] = ()
    way: tuple[float, float, float]

    def moved(self, raw: RawGaussians, time: float) -> RawGaussians:
        return replace(raw, means=(raw.means + time * np.array(self.way)).astype(np.float32))

    def rows(self, index: Any) -> Self:
        return self

    def arrays(self) -> Arrays:
        return {}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, Any]) -> Self:
        raise NotImplementedError

    @classmethod
    def check(cls, arrays: Mapping[str, Any], count: int) -> None:
        raise NotImplementedError


def slope(scene: Scene) -> RawGaussians:
    """A tilted plane before the camera, z = 60 + x / 4, of small opaque Gaussians."""
    x, y = (part.ravel() for part in np.meshgrid(np.arange(-60, 60, 0.8), np.arange(-40, 40, 0.8)))
    count = len(x)
    return RawGaussians(
        means=np.stack([x, y, 60 + x / 4], axis=1).astype(np.float32),
        quats=np.tile(np.float32([1, 0, 0, 0]), (count, 1)),
        log_scales=np.full((count, 3), np.log(0.4), np.float32),
        opacity_logits=np.full(count, 3, np.float32),
        colors=np.full((count, 3), 0.5, np.float32),
        harmonics=np.zeros((count, 0, 3), np.float32),
    )


def test_points_of_a_known_surface_go_where_it_goes(scene: Scene, tmp_path: Path) -> None:
    way = np.array([3.0, -2.0, 4.0])
    model = DynamicGaussians(slope(scene), Drift((3.0, -2.0, 4.0)))
    moving = replace(scene, model=model)
    camera, path = scene.cameras[0], tmp_path / "a.csv"
    moments = tuple(MomentRecord(time=time, camera=camera, near=0.1) for time in (0.0, 0.5, 1.0))
    points = ((20, 20), (40, 30), (63, 0))
    record = extended(Tracks, scene.record, points=points, start=moments[0], moments=moments)
    run_to_end(write_tracks(record, moving, path))
    rows = list(csv.DictReader(path.read_text().splitlines()))
    assert tuple(rows[0]) == COLUMNS
    assert [row["point"] for row in rows] == ["0"] * 3 + ["1"] * 3 + ["2"] * 3
    for row, (column, line) in zip(rows, np.repeat(points, 3, axis=0), strict=True):
        slant = (column + 0.5 - camera.cx) / camera.fx
        depth = 60 / (1 - slant / 4)
        start = np.array([slant * depth, (line + 0.5 - camera.cy) / camera.fy * depth, depth])
        place = np.array([float(row[axis]) for axis in "xyz"])
        assert np.abs(place - start - float(row["time"]) * way).max() < 0.6, row
        pixel, _ = camera.project(place[None])
        assert np.allclose(pixel[0], [float(row["column"]), float(row["row"])], atol=1e-3)
        inside = (pixel >= 0).all() and (pixel < [camera.width, camera.height]).all()
        assert row["seen"] == str(int(inside))
    assert {row["seen"] for row in rows} == {"0", "1"}  # The corner leaves the image.


def test_tracks_of_a_run_come_again_with_their_definitions(
    runs: dict[str, Path], vesselsplat: Cli, tmp_path: Path
) -> None:
    path = tmp_path / "a.csv"
    done = vesselsplat("export", runs["original"], "--tracks", path, "--points", "30,20", "12,40")
    assert (done.code, done.error) == (0, "")
    rows = list(csv.DictReader(path.read_text().splitlines()))
    assert len(rows) == 20
    assert (rows[0]["column"], rows[0]["row"], rows[0]["seen"]) == ("30.5", "20.5", "1")
    told = json.loads((tmp_path / "a.csv.json").read_text())
    assert (told["kind"], told["points"]) == ("tracks", [[30, 20], [12, 40]])
    assert "in mm" in told["definitions"]["x, y, z"]
    again = vesselsplat("replay", path, "--source", runs["original"])
    assert again.out.rstrip().endswith("identical"), again.error + again.out
    assert "tracks" in vesselsplat("info", path).out
    content = path.read_bytes()
    for damaged in (b"", content[:-9], content + b"1,2\n", content[:60] + b"\xff" + content[60:]):
        path.write_bytes(damaged)
        with pytest.raises(UserError, match=r"expected a table written by VesselSplat \(.*\): .*a\.csv$"):
            list(arrays(path))


@pytest.mark.parametrize("form", ["transforms", "colmap"])
def test_cameras_of_other_programs_come_back_exactly(
    runs: dict[str, Path], scene: Scene, vesselsplat: Cli, tmp_path: Path, form: str
) -> None:
    path = tmp_path / ("transforms.json" if form == "transforms" else "colmap")
    flags = ("--cameras", path, "--cameras-format", form, "--frames", 0, 7)
    assert vesselsplat("export", runs["original"], *flags).code == 0
    back = read_cameras(path)
    assert [one.name for one in back] == ["frame-000000", "frame-000007"]
    for one, frame in zip(back, (0, 7), strict=True):
        assert np.allclose(one.camera.camera_from_world, scene.cameras[frame].camera_from_world, atol=1e-12)
        assert (one.camera.fx, one.camera.cx) == (scene.cameras[frame].fx, scene.cameras[frame].cx)
    if form == "transforms":
        assert [one["time"] for one in json.loads(path.read_text())["frames"]] == [0.0, 0.7]
        return
    assert len((path / "cameras.txt").read_text().splitlines()) == 2  # One lens for both.
    lines = (path / "points3D.txt").read_text().splitlines()[1:]
    points = np.array([line.split()[1:7] for line in lines], float)
    splats = scene.model.at(0.0)
    assert np.allclose(points[:, :3], splats.means, rtol=1e-6)
    assert np.abs(points[:, 3:] - 255 * splats.colors.clip(0, 1)).max() <= 0.51


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (("--npz", "a.zip"), "--npz: expected the name of a .npz file, got a.zip"),
        (("--tracks", "a.csv"), "expected --tracks FILE.csv with --points X,Y ..., got one of the two"),
        (("--tracks", "a.csv", "--points", "3;4"), "column,row as whole numbers from 0, got 3;4"),
        (("--tracks", "a.csv", "--points", "-1,5"), "column,row as whole numbers from 0, got -1,5"),
        (("--tracks", "a.csv", "--points", "3,4", "99,4"), "got 99,4 at frame 0, counted from 0"),
        (("--cameras", "a.txt", "--cameras-format", "colmap"), "expected a folder for COLMAP, got a.txt"),
    ],
)
def test_what_cannot_be_exported_is_refused(
    runs: dict[str, Path], vesselsplat: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    flags: tuple[str, ...], said: str,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    done = vesselsplat("export", runs["original"], *flags)
    assert done.code == 2
    assert said in done.error
    assert list(tmp_path.iterdir()) == []
