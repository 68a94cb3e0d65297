"""`vesselsplat export` and files of splats: what other programs get, and what is refused."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.errors import UserError
from app.files.provenance import read_provenance
from app.gui.work.opening import OpenRequest, open_path
from app.runs.run_folder import RunFolder
from app.scenes.cpu_rendering import DrawOptions, draw_on_cpu, over
from app.scenes.observed import observed
from app.scenes.scene import open_scene
from renderer.camera import Camera
from renderer.camera_path import CameraPath, Keyframe
from renderer.editing.edits import Edits
from renderer.editing.mask import Mask
from renderer.framing import framing
from renderer.gaussians import DynamicGaussians
from renderer.near_plane import near_plane
from renderer.ply_comments import joined
from renderer.ply_elements import read_ply
from renderer.rasterize.cpu import render
from renderer.rotations import exponential, matrix
from renderer.splat_files import read_splats
from renderer.splat_files.inria_ply import ply_bytes
from renderer.unobserved import GREY
from renderer.view_files import Views, read_views, views_json
from tests.app.conftest import Cli
from tests.renderer.splat_files.files import gaussians, zipped


def test_a_run_becomes_a_file_a_frame_that_draws_the_same(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    call = vesselsplat("export", runs["original"], "--ply", tmp_path / "ply", "--frames", 0, 3, 9)
    assert (call.code, call.error) == (0, "")
    names = sorted(path.name for path in (tmp_path / "ply").iterdir())
    assert names == ["frame-000000.ply", "frame-000003.ply", "frame-000009.ply"]
    run = RunFolder(runs["original"])
    record, model = run.record(), run.model()
    for index in (0, 9):
        path = tmp_path / "ply" / f"frame-{index:06d}.ply"
        camera = record.cameras[index]
        near = near_plane(model, camera)
        own = draw_on_cpu(model.at(record.time(index)), camera, DrawOptions(near)).image
        theirs = render(read_splats(path).raw.splats(), camera, near=near).image
        assert np.allclose(own, theirs, atol=1e-5)
        comments = read_ply(path.read_bytes()).comments
        assert "SplatRenderMode: default" in comments  # What other viewers look for.
        assert max(len(f"comment {line}") for line in comments) < 400  # More makes other programs abort.
        facts = json.loads(joined("vesselsplat", comments) or "")
        assert (facts["frame"], facts["time"]) == (index, record.time(index))
        assert facts["notice"] == "Research use only. Not a medical device."
        assert str(tmp_path) not in json.dumps(facts)


def test_a_run_becomes_a_video_and_cameras(runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli) -> None:
    video, cameras = tmp_path / "a.mp4", tmp_path / "cameras.json"
    call = vesselsplat("export", runs["original"], "--video", video, "--cameras", cameras, "--size", 64, 48)
    assert call.code == 0, call.error
    capture = cv2.VideoCapture(str(video))
    assert capture.get(cv2.CAP_PROP_FRAME_COUNT) == 10
    assert (capture.get(cv2.CAP_PROP_FRAME_WIDTH), capture.get(cv2.CAP_PROP_FPS)) == (64, 15)
    facts = json.loads((tmp_path / "a.mp4.json").read_text())
    assert [moment["frame"] for moment in facts["moments"]] == list(range(10))
    poses = json.loads(cameras.read_text())
    camera = RunFolder(runs["original"]).record().cameras[0].resized(64, 48)
    assert (poses[0]["fx"], poses[0]["width"], poses[9]["id"]) == (camera.fx, 64, 9)
    assert np.allclose(poses[0]["rotation"], camera.world_from_camera[:3, :3])
    assert np.allclose(poses[0]["position"], camera.position)


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_a_degree_is_filled_up_for_programs_that_ask_for_it(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli, degree: int
) -> None:
    flags = ("--frames", 3, "--ply", tmp_path, "--sh-degree", degree)
    assert vesselsplat("export", runs["original"], *flags).code == 0
    path = tmp_path / "frame-000003.ply"
    fields = read_ply(path.read_bytes()).elements[0].fields
    count = 3 * (degree + 1) ** 2 - 3  # What the loader of the first viewer demands, of degree 3.
    assert [name for name in fields if "f_rest" in name] == [f"f_rest_{place}" for place in range(count)]
    call = vesselsplat("replay", path, "--source", runs["original"].parent)
    assert (call.code, call.error) == (0, "")


def test_no_degree_loses_colours_by_direction(tmp_path: Path, vesselsplat: Cli) -> None:
    file = tmp_path / "a.ply"
    file.write_bytes(ply_bytes(gaussians(3, 8)))
    call = vesselsplat("export", file, "--ply", tmp_path / "out", "--sh-degree", 1)
    assert (call.code, call.error.count("\n")) == (2, 1)
    assert "--sh-degree" in call.error
    assert "degree 2" in call.error
    assert not (tmp_path / "out").exists()
    call = vesselsplat("export", file, "--cameras", tmp_path / "cameras.json", "--sh-degree", 3)
    assert call.code == 2
    assert "--ply" in call.error


def test_one_gaussian_is_told_as_one(tmp_path: Path, vesselsplat: Cli) -> None:
    (tmp_path / "a.ply").write_bytes(ply_bytes(gaussians(1)))
    call = vesselsplat("export", tmp_path / "a.ply", "--ply", tmp_path / "out")
    assert call.out.endswith(": 1 splat file of 1 Gaussian\n")


def test_a_file_of_splats_is_drawn_from_where_all_are_seen(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    vesselsplat("export", runs["original"], "--ply", tmp_path, "--frames", 0)
    path = tmp_path / "frame-000000.ply"
    assert vesselsplat("render", path, "--out", tmp_path / "out").code == 0
    picture = tmp_path / "out" / "frame-000000.png"
    assert cv2.imread(str(picture)).shape == (720, 960, 3)
    assert read_provenance(picture)["splats"]["name"] == path.name
    scene = open_scene(path)
    (camera,) = scene.cameras
    pixels, depth = camera.project(scene.model.means.astype(np.float64))
    inside = (depth > 0) & np.all((pixels >= 0) & (pixels <= (960, 720)), axis=1)
    assert np.mean(inside) >= 0.94
    assert np.ptp(pixels[inside], axis=0).max() > 400


@pytest.mark.parametrize("count", [0, 1, 2])
def test_few_splats_have_a_camera_too(runs: dict[str, Path], count: int) -> None:
    model = RunFolder(runs["original"]).model()
    few: DynamicGaussians = model.rows(np.arange(count))
    camera = framing(few)
    assert np.isfinite(camera.camera_from_world).all()
    assert render(few.at(0.0), camera, near=near_plane(few, camera)).image.shape == (720, 960, 3)


def test_a_run_may_be_named_like_a_file_of_splats(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    shutil.copytree(runs["original"], tmp_path / "run.ply")
    call = vesselsplat("render", tmp_path / "run.ply", "--out", tmp_path / "out", "--frames", 3)
    assert (call.code, [path.name for path in (tmp_path / "out").iterdir()]) == (0, ["frame-000003.png"])


def test_repairs_are_said(tmp_path: Path, vesselsplat: Cli, runs: dict[str, Path]) -> None:
    vesselsplat("export", runs["original"], "--ply", tmp_path, "--frames", 0)
    path = tmp_path / "frame-000000.ply"
    content = bytearray(path.read_bytes())
    content[-4:] = np.float32("nan").tobytes()
    path.write_bytes(content)
    call = vesselsplat("render", path, "--out", tmp_path / "out", "--size", 32, 24)
    assert call.code == 0
    assert "1 of" in call.error


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        ((), "--ply DIR"),
        (("--ply", "{out}", "--frames", "99"), "--frames"),
        (("--video", "{out}.mp4", "--frames-per-second", "0"), "--frames-per-second"),
        (("--video", "{out}.mp4", "--frames-per-second", "1e-4"), "--frames-per-second: expected 0.000278"),
        (("--video", "{out}.txt"), ".webm"),
        (("--npz", "{out}.npz", "--time", "0.5", "--frames", "0"), "--time or --frames"),
    ],
)
def test_a_mistake_is_one_line(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli, flags: tuple[str, ...], said: str
) -> None:
    filled = [flag.format(out=tmp_path / "out") for flag in flags]
    call = vesselsplat("export", runs["original"], *filled)
    assert call.code == 2
    assert call.error.count("\n") == 1
    assert said in call.error
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.ply", b"", "an empty file"),
        ("a.ksplat", bytes(4096), ".ksplat"),
        ("a.sog", zipped("meta.json", "means_l.webp"), "SOG"),
        ("meta.json", b'{"means": {}, "sh0": {}}', "SOG"),
        ("a.spz", b"NGSP\5\0\0\0" + bytes(24), "version 5"),
        ("a.ply", zipped("point_cloud.ply"), "point_cloud.ply"),
    ],
)
def test_a_file_that_is_not_read_is_named_with_what_to_do(
    tmp_path: Path, vesselsplat: Cli, name: str, content: bytes, said: str
) -> None:
    (tmp_path / name).write_bytes(content)
    for command in ("render", "export"):
        out = ("--out" if command == "render" else "--ply", tmp_path / "out")
        call = vesselsplat(command, tmp_path / name, *out)
        assert (call.code, call.error.count("\n")) == (2, 1)
        assert said in call.error
        assert call.error.endswith(f"{name}\n")
        with pytest.raises(UserError, match=said):
            list(open_path(OpenRequest(tmp_path / name)))


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (ply_bytes(gaussians(0)), "no Gaussians"),
        (ply_bytes(gaussians(1)), ""),
        (ply_bytes(gaussians(9)) + b"more", "4 bytes after the last of 9"),
        (ply_bytes(gaussians(9)).replace(b"\n", b"\r\n", 3), ""),
    ],
)
def test_odd_files_are_drawn_and_what_is_odd_is_said(
    tmp_path: Path, vesselsplat: Cli, content: bytes, said: str
) -> None:
    path = tmp_path / "mit Leerzeichen, äöü 内視鏡.ply"
    path.write_bytes(content)
    call = vesselsplat("render", path, "--out", tmp_path / "out", "--size", 48, 64)
    assert call.code == 0
    assert (said in call.error) if said else call.error == ""
    facts = read_provenance(tmp_path / "out" / "frame-000000.png")
    assert facts["splats"]["name"] == path.name
    assert [notice for notice in facts["notices"] if said in notice] == facts["notices"]
    image = cv2.imread(str(tmp_path / "out" / "frame-000000.png"))
    assert (image != image[0, 0]).any() == (said != "no Gaussians")


def test_a_damaged_file_is_one_line(tmp_path: Path, vesselsplat: Cli) -> None:
    (tmp_path / "a.ply").write_bytes(
        b"ply\nformat ascii 1.0\nelement vertex 7\nproperty float x\nend_header\n1"
    )
    for command in (("render", "{}", "--out"), ("export", "{}", "--ply")):
        call = vesselsplat(*(part.format(tmp_path / "a.ply") for part in command), tmp_path / "out")
        assert call.code == 2
        assert "a.ply" in call.error
        assert not (tmp_path / "out").exists()


def test_cameras_come_back_as_they_went(runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli) -> None:
    """A picture of each, at one moment."""
    file = tmp_path / "cameras.json"
    assert vesselsplat("export", runs["original"], "--cameras", file, "--frames", 0, 5).code == 0
    flags = ("--camera", file, "--time", 0.5, "--out", tmp_path / "out")
    assert vesselsplat("render", runs["original"], *flags).code == 0
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert names == ["0000-frame-000000.png", "0001-frame-000005.png"]
    long = tmp_path / "long.json"
    long.write_text(file.read_text().replace("frame-000000", f"{'far/' * 80}a").replace("frame-000005", "b"))
    flags = ("--camera", long, "--time", 0.5, "--out", tmp_path / "long")
    assert vesselsplat("render", runs["original"], *flags).code == 0
    first, second = sorted(path.name for path in (tmp_path / "long").iterdir())
    assert (len(first), first[-10:], second) == (5 + 60 + 4, "-far-a.png", "0001-b.png")
    call = vesselsplat("render", runs["original"], "--camera", file, "--frames", 1, "--out", tmp_path / "no")
    assert call.code == 2
    assert "--frames" in call.error


def test_pictures_of_exported_cameras_are_those_of_the_cameras_that_were_given(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    """With the principal point off the middle, pixels that are not square, and another shape."""
    camera = RunFolder(runs["original"]).record().cameras[0]
    turned = camera.camera_from_world.copy()
    turned[:3, :3] = matrix(exponential(np.array([0.1, 0.3, 0.2]))) @ turned[:3, :3]
    odd = replace(camera, fy=1.1 * camera.fy, cx=camera.cx - 3.3, cy=camera.cy + 5.7).moved(turned)
    (tmp_path / "odd.json").write_text(json.dumps(odd.to_json()))
    flags = ("--camera", tmp_path / "odd.json", "--time", 0.5, "--size", 60, 80)
    file = tmp_path / "cameras.json"
    call = vesselsplat("export", runs["original"], "--cameras", file, *flags)
    assert call.code == 0
    assert "principal point" in call.error
    again = ("--camera", file, "--time", 0.5)
    for out, asked in (("given", flags), ("read", again)):
        assert vesselsplat("render", runs["original"], *asked, "--out", tmp_path / out).code == 0
    given, read = (cv2.imread(str(tmp_path / out / "time-0.5000.png")) for out in ("given", "read"))
    assert given.shape == (80, 60, 3)
    assert given.std() > 10
    np.testing.assert_array_equal(given, read)


SLOWLY = ("--frames-per-second", "8")


def path_file(folder: Path, run: Path) -> Path:
    """From the clip's camera to one nearer and turned, backwards in time."""
    camera = RunFolder(run).record().cameras[0]
    turned = camera.camera_from_world.copy()
    turned[:3, :3] = matrix(exponential(np.array([0.0, 0.3, 0.1]))) @ turned[:3, :3]
    turned[2, 3] -= 5
    keys = (Keyframe(0.0, 0.9, camera), Keyframe(0.5, 0.25, camera.moved(turned)))
    file = folder / "path.json"
    file.write_bytes(views_json(Views(path=CameraPath(keys), unit="mm")))
    return file


def test_a_path_is_filmed_from_its_very_poses_and_times_and_again_the_same(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    file, first, second = path_file(tmp_path, runs["original"]), tmp_path / "a.mp4", tmp_path / "b.mp4"
    for video in (first, second):
        call = vesselsplat("export", runs["original"], "--video", video, "--path", file, *SLOWLY)
        assert call.code == 0, call.error
    assert first.read_bytes() == second.read_bytes()
    assert vesselsplat("replay", first, "--source", runs["original"].parent).code == 0
    moments = json.loads((tmp_path / "a.mp4.json").read_text())["moments"]
    wanted = read_views(file).path.moments(8.0)
    assert [moment["time"] for moment in moments] == [key.time for key in wanted]
    assert [Camera.from_json(moment["camera"]) for moment in moments] == [key.camera for key in wanted]
    assert len(moments) == 5


def test_pictures_along_a_path_are_the_model_at_its_moments(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    file = path_file(tmp_path, runs["original"])
    call = vesselsplat(
        "render", runs["original"], "--out", tmp_path / "out", "--path", file, *SLOWLY, "--unobserved"
    )
    assert call.code == 0, call.error
    model = RunFolder(runs["original"]).model()
    for place, key in enumerate(read_views(file).path.moments(8.0)):
        picture = cv2.imread(str(tmp_path / "out" / f"path-{place:06d}.png"))[..., ::-1]
        near = near_plane(model, key.camera)
        drawn = over(draw_on_cpu(model.at(key.time), key.camera, DrawOptions(near)), GREY)
        np.testing.assert_array_equal(picture, drawn)


@pytest.mark.parametrize(
    ("content", "flags", "words"),
    [
        (None, ("--time", "0.5"), "without --time"),
        (None, ("--frames", "all"), "without --frames"),
        (b"{}", (), "format"),
        (views_json(Views()), (), "at least one keyframe"),
        (None, ("--frames-per-second", "-1"), "--frames-per-second"),
    ],
)
def test_a_path_that_cannot_be_followed_is_one_line(
    runs: dict[str, Path],
    tmp_path: Path,
    vesselsplat: Cli,
    content: bytes | None,
    flags: tuple[str, ...],
    words: str,
) -> None:
    file = path_file(tmp_path, runs["original"])
    if content is not None:
        file.write_bytes(content)
    call = vesselsplat("render", runs["original"], "--out", tmp_path / "out", "--path", file, *flags)
    assert call.code == 2
    assert words in call.error
    assert call.error.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_splat_files_without_what_no_frame_shows(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    run, scene = runs["original"], open_scene(runs["original"])
    assert scene.shown is not None
    written = vesselsplat("export", run, "--ply", tmp_path / "ply", "--frames", 3, "--without-unobserved")
    assert written.code == 0, written.error
    assert f"of {scene.shown.sum()} Gaussians" in written.out
    file = tmp_path / "ply" / "frame-000003.ply"
    whole = scene.model.at(scene.time(3)).means
    assert np.array_equal(read_splats(file).raw.means, whole[scene.shown])
    again = vesselsplat("replay", file, "--source", run)
    assert (again.code, again.out.rstrip().endswith("identical")) == (0, True), again.error + again.out
    refused = vesselsplat("export", file, "--ply", tmp_path / "other", "--without-unobserved")
    assert (refused.code, refused.error.count("\n")) == (2, 1)
    assert "got a splat file" in refused.error
    assert not (tmp_path / "other").exists()


def test_an_edited_scene_is_without_them_as_well(runs: dict[str, Path]) -> None:
    scene = open_scene(runs["original"])
    first = Mask.of(np.arange(len(scene.model)) < 200)
    edits = Edits.none(len(scene.model)).selecting(first, "replace").deleting()
    kept = observed(scene.edited(edits))
    assert scene.shown is not None
    assert np.array_equal(kept.model.raw.means, scene.model.raw.means[200:][scene.shown[200:]])
    assert kept.shown is not None
    assert kept.shown.all()
